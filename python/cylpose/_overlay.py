"""The picture that shows what was estimated."""

import numpy as np
import numpy.typing as npt

from . import _cylpose
from ._models import Camera, Parts, as_camera, as_parts
from ._results import FrameEstimate


def overlay(image: npt.NDArray[np.uint8], camera: Camera, parts: Parts, result: FrameEstimate) -> npt.NDArray[np.uint8]:
    """A copy of the image (B G R or grey, as for Estimator.estimate), B G R, with search region, measured sides, cylinder,
    axis, centre and numbers drawn in."""
    return _cylpose.overlay(image, as_camera(camera), as_parts(parts), result)
