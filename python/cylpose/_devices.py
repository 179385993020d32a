"""What can do the per-pixel work."""

from dataclasses import dataclass

from . import _cylpose


@dataclass(frozen=True, slots=True)
class OpenclDevice:
    """A device of the backend opencl."""

    index: int  #: its place in devices(), and a name for it: device="1"
    platform: str
    name: str
    type: str  #: cpu, gpu, accelerator or custom
    compute_units: int
    memory_bytes: int
    device_version: str
    driver_version: str
    shares_memory: bool  #: with the host, so the device says
    sub_devices: int  #: at most so many parts can be made of it
    unusable: str  #: why cylpose cannot use it; empty when it can


def backends() -> dict[str, str]:
    """The names that the argument `backend` takes besides "default", each with a description."""
    return _cylpose.backends()


def devices() -> list[OpenclDevice]:
    """All OpenCL devices of all platforms; empty where there is no OpenCL."""
    return [OpenclDevice(*device) for device in _cylpose.devices()]
