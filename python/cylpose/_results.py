"""What cylpose says about a frame and the parts in it."""

import enum
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


class PoseStatus(enum.StrEnum):
    """Where a pose comes from. Equal to the words in poses files: status == "ok"."""

    NONE = "none"  #: no cylinder found, or none that passed the self-check; `reason` says which test failed
    OK = "ok"  #: measured in this frame
    PREDICTED = "predicted"  #: from the filter only


class Roi(NamedTuple):
    """Columns [x, x + width) and rows [y, y + height) of the image."""

    x: int
    y: int
    width: int
    height: int


@dataclass(frozen=True, slots=True, eq=False)
class PoseEstimate:
    """One part in one frame: metres and radians in the camera optical frame. Without a pose (status "none") what is
    measured is NaN. Compared by identity, as arrays are not simply equal or unequal."""

    name: str  #: of the part
    status: PoseStatus
    reason: str  #: for "none" and "predicted": the test that fired, in words
    center_in_cam: Floats  #: (3,): middle of the two base centres, m
    axis_in_cam: Floats  #: (3,): unit vector; its sign is a rule (ay <= 0, then ax >= 0, then az >= 0), or continuous (filter)
    covariance: Floats = field(repr=False)
    """(6, 6): of x, y, z of the centre in metres, then rotations about the fixed x, y, z axes in radians. The roll about
    the axis cannot be observed: its variance is the full circle's, (2 pi)^2 / 12."""
    sigma_center_m: Floats  #: (3,): standard deviations of the centre
    sigma_axis_deg: float  #: standard deviation of the axis direction where it is larger
    rms_px: float  #: root mean square distance of the supporting edge points from the predicted outline
    support: int  #: number of supporting edge points
    seen: float  #: share of the predicted outline inside the image that edge points support, 0..1
    sides: Floats = field(repr=False)
    """(2, 3): the measured side lines, normal (x, y) and distance, in pixels of the camera without its distortion; zero
    where no side is seen."""


@dataclass(frozen=True, slots=True, eq=False)
class FrameEstimate:
    """Everything about one frame."""

    frame: int  #: number in the stream, from 0
    timestamp_s: float  #: of the stream; NaN from an Estimator, to which frames have no time
    name: str  #: the file, or file and number of the frame; empty for frames that the program brings
    parts: tuple[PoseEstimate, ...]  #: one per part model, in its order
    searched: Roi  #: the region of the image in which the parts were looked for
    times_ms: dict[str, float] = field(repr=False)  #: of each stage, by name
    error: str = ""  #: why the file could not be read; its parts are then "none"
    image: npt.NDArray[np.uint8] | None = field(default=None, repr=False)  #: B G R or grey; from stream(images=True)


# Words are looked up faster here than by the enumeration.
_STATUSES = {status.value: status for status in PoseStatus}


def frame_estimate(names: list[str], frame: int, timestamp_s: float, native: tuple[Any, ...], name: str = "",
                   error: str = "", image: npt.NDArray[np.uint8] | None = None) -> FrameEstimate:
    """Of what the extension returns for a frame, and the parts' names."""
    searched, parts, times_ms = native
    estimates = tuple([PoseEstimate(part, _STATUSES[values[0]], *values[1:]) for part, values in zip(names, parts)])
    return FrameEstimate(frame, timestamp_s, name, estimates, Roi._make(searched), times_ms, error, image)
