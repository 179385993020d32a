"""Results as one NumPy array."""

from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from ._cylpose import POSES_HEADER
from ._results import FrameEstimate, PoseStatus

_COLUMNS = POSES_HEADER.split(",")
_INTEGERS = {"frame": "i8"}


def to_table(results: Iterable[FrameEstimate]) -> npt.NDArray[Any]:
    """A structured array with the columns of a poses CSV, one row per frame and part: table["cz"]. NaN where a CSV is
    empty."""
    rows = [(result.frame, result.timestamp_s, part.name, part.status.value, *part.center_in_cam, *part.axis_in_cam,
             *part.sigma_center_m, part.sigma_axis_deg, part.rms_px) for result in results for part in result.parts]
    texts = {"part": f"U{max((len(row[2]) for row in rows), default=1)}",
             "status": f"U{max(len(status) for status in PoseStatus)}"}
    return np.array(rows, dtype=[(name, texts.get(name) or _INTEGERS.get(name, "f8")) for name in _COLUMNS])
