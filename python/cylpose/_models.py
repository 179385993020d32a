"""The camera and the cylinders to look for, and their files."""

import os
from collections.abc import Iterable
from dataclasses import dataclass

from . import _cylpose


@dataclass(frozen=True, slots=True)
class CameraModel:
    """A calibrated camera: x right, y down, z forward; pixel (0, 0) is the centre of the top-left pixel."""

    width: int  #: pixels, of the calibration and of every image
    height: int
    fx: float  #: focal length in pixels
    fy: float
    cx: float  #: principal point in pixels
    cy: float
    distortion_model: str = "none"  #: none, plumb_bob, rational_polynomial or equidistant (fisheye)
    distortion: tuple[float, ...] = ()  #: coefficients in OpenCV's order
    transfer: str = "srgb"  #: how light becomes codes: srgb, or linear


@dataclass(frozen=True, slots=True)
class PartModel:
    """A right circular cylinder of one colour."""

    name: str
    radius_m: float
    height_m: float  #: distance of the two bases
    hue_deg: tuple[float, float]  #: from, upward to; 0..360, red 0, green 120, blue 240; may wrap: (345, 15)
    min_saturation: float = 0.0  #: HSV, 0..1
    min_value: float = 0.0  #: HSV, 0..1


def load_camera(path: str | os.PathLike[str]) -> CameraModel:
    """Reads a calibration: YAML as camera_info files and OpenCV have it. Raises InputError."""
    return CameraModel(*_cylpose.load_camera(path))


def load_parts(path: str | os.PathLike[str]) -> list[PartModel]:
    """Reads the list of a parts file (YAML). Raises InputError."""
    return [PartModel(*part) for part in _cylpose.load_parts(path)]


#: Wherever a camera or parts are asked for, their file does as well.
Camera = CameraModel | str | os.PathLike[str]
Parts = Iterable[PartModel] | str | os.PathLike[str]


def as_camera(camera: Camera) -> CameraModel:
    return load_camera(camera) if isinstance(camera, (str, os.PathLike)) else camera


def as_parts(parts: Parts) -> list[PartModel]:
    return load_parts(parts) if isinstance(parts, (str, os.PathLike)) else list(parts)
