"""Frames that overlap: recordings and cameras that cylpose reads itself, and frames that the program brings."""

import os
import weakref
from collections.abc import Iterator, Sequence
from types import TracebackType
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from . import _cylpose
from ._models import Camera, Parts, as_camera, as_parts
from ._results import FrameEstimate, frame_estimate


class _Results(Iterator[FrameEstimate]):
    """Results in the order of the frames, until the stream ends; with `with` it is closed behind the block."""

    _native: _cylpose.Stream | _cylpose.Pipeline

    def __init__(self, names: list[str]) -> None:
        self._names = names
        # Also at the end of the program: threads must not outlive what they work on.
        self._finalizer = weakref.finalize(self, self._native.close)

    def __next__(self) -> FrameEstimate:
        return self._result(*self._native.next())

    def close(self) -> None:
        """Ends the work at once; frames under way are dropped. Happens by itself when nobody holds the object any more."""
        self._finalizer()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 traceback: TracebackType | None) -> None:
        self.close()

    def _result(self, frame: int, timestamp_s: float, name: str, error: str, image: npt.NDArray[np.uint8] | None,
                native: tuple[Any, ...]) -> FrameEstimate:
        return frame_estimate(self._names, frame, timestamp_s, native, name, error, image)


class Stream(_Results):
    """What stream() returns: an iterator over the results."""

    def __init__(self, inputs: Sequence[bytes], camera: Camera, parts: Parts, *, backend: str, device: str, filter: bool,
                 live: bool, lag: int, fps: float, images: bool) -> None:
        models = as_parts(parts)
        self._native = _cylpose.Stream(inputs, as_camera(camera), models, backend, device, filter, live, lag, fps, images)
        super().__init__([part.name for part in models])

    @property
    def dropped(self) -> int:
        """Frames of a live stream that were dropped because newer ones had come."""
        return self._native.dropped()

    @property
    def warnings(self) -> list[str]:
        """At the end: what is to be known about the input, such as a video that is cut short."""
        return self._native.warnings()


def stream(inputs: str | os.PathLike[str] | Sequence[str | os.PathLike[str]], camera: Camera, parts: Parts, *,
           backend: str = "default", device: str = "", filter: bool = False, live: bool = False, lag: int = 0,
           fps: float = 30.0, images: bool = False) -> Stream:
    """Poses in all frames of images, folders, patterns ("frame_%04d.png", "*.png"), videos or cameras ("/dev/video0").

    Several frames are worked on at once; results come in order, and equal those of `cylpose estimate`. Leaving the loop
    early ends the work.

    camera, parts, backend, device: as for Estimator.
    filter: filters poses over time, with the status "predicted" while a part is hidden.
    live: drops frames that are stale instead of falling behind; recordings play at their own speed.
    lag: frames at work at once, 1..64; 0: 3, or 1 when live. 1 gives the poses of an Estimator.
    fps: frames per second of image files and of videos that do not say.
    images: results hold their images, and keep them in memory for as long as they live.

    A file that cannot be read gives a result with `error` set. Raises InputError for what cannot be opened, and, from the
    loop, for frames of another size than the calibration; DeviceError when a camera or device fails.
    """
    paths = [inputs] if isinstance(inputs, (str, os.PathLike)) else inputs
    return Stream([os.fsencode(path) for path in paths], camera, parts, backend=backend, device=device, filter=filter,
                  live=live, lag=lag, fps=fps, images=images)


class Pipeline(_Results):
    """For frames that the program brings: put them, and take the results from the iterator, from the same thread or
    another.

        pipeline = cylpose.Pipeline("camera.yaml", "parts.yaml", filter=True)
        for timestamp_s, image in frames:
            pipeline.put(image, timestamp_s)
            for result in pipeline.ready(): ...
        pipeline.finish()
        for result in pipeline: ...

    Arguments as for stream(). The iterator waits for the next result, up to the last one before finish(). With live=True a
    frame that waits is dropped for a newer one, and has no result.
    """

    _native: _cylpose.Pipeline

    def __init__(self, camera: Camera, parts: Parts, *, backend: str = "default", device: str = "", filter: bool = False,
                 live: bool = False, lag: int = 0) -> None:
        models = as_parts(parts)
        self._native = _cylpose.Pipeline(as_camera(camera), models, backend, device, filter, live, lag)
        super().__init__([part.name for part in models])

    def put(self, image: npt.NDArray[np.uint8], timestamp_s: float, color_order: str = "bgr") -> int:
        """Hands a frame over and returns its number; waits while there is no room, unless live.

        image, color_order: as for Estimator.estimate. The pixels are not copied and must not change until the result has
        come. timestamp_s: seconds, increasing where the poses are filtered.
        """
        return self._native.put(image, timestamp_s, color_order)

    def ready(self) -> Iterator[FrameEstimate]:
        """Iterates over the results that have come, without waiting."""
        while (values := self._native.try_next()) is not None:
            yield self._result(*values)

    def finish(self) -> None:
        """No more frames: waits until all are done, and lets the iterator end behind the last result."""
        self._native.finish()
