"""One image at a time."""

import itertools
import math

import numpy as np
import numpy.typing as npt

from . import _cylpose
from ._models import Camera, Parts, as_camera, as_parts
from ._results import FrameEstimate, frame_estimate


class Estimator:
    """Poses of the parts in images that come one after the other.

    camera, parts: objects or their files. backend: who does the per-pixel work, a name out of backends(), or "default":
    opencl where a device works, else serial; all give the same poses bit for bit, except opencv. device: what opencl runs
    on, as the command's --device (an index, a type or part of a name); empty for its own choice.

    Where a part was in the last image decides where it is looked for first in the next one; a part that is not there is
    looked for everywhere. Any thread may call; calls of several threads wait for each other.
    Raises InputError for what cannot be used, DeviceError for a device that does not work.
    """

    def __init__(self, camera: Camera, parts: Parts, backend: str = "default", device: str = "") -> None:
        models = as_parts(parts)
        self._names = [part.name for part in models]
        self._native = _cylpose.Estimator(as_camera(camera), models, backend, device)
        self._numbers = itertools.count()

    def estimate(self, image: npt.NDArray[np.uint8], color_order: str = "bgr") -> FrameEstimate:
        """The pose of every part in the image: uint8 of shape (height, width, 3), or (height, width) for grey.

        The pixels are not copied, whatever the distance of the rows (so a crop of a larger array will do), and must not
        change meanwhile; Python's lock is released. color_order: "bgr" (as OpenCV) or "rgb".
        Raises InputError for any other array and for an image of another size than the calibration, DeviceError.
        """
        native = self._native.estimate(image, color_order)
        return frame_estimate(self._names, next(self._numbers), math.nan, native)

    def reset(self) -> None:
        """Forgets where the parts were: the next image belongs to another stream, is searched as a whole and has the
        number 0."""
        self._native.reset()
        self._numbers = itertools.count()
