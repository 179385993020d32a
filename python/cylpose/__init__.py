"""Poses of coloured cylinders of known size from the images of one calibrated camera.

    estimator = cylpose.Estimator("camera.yaml", "parts.yaml")
    result = estimator.estimate(image)                          # uint8, height x width x 3, B G R as OpenCV has it
    for result in cylpose.stream("video.mp4", "camera.yaml", "parts.yaml", filter=True):
        print(result.frame, result.parts[0].center_in_cam)

Camera optical frame: x right, y down, z forward, metres; pixel (0, 0) is the centre of the top-left pixel. What goes wrong
is a cylpose.Error whose text names file, value and remedy. Warnings go to the logger "cylpose".
"""

from ._cylpose import VERSION as __version__
from ._devices import OpenclDevice, backends, devices
from ._errors import DeviceError, Error, InputError, OutputError
from ._estimator import Estimator
from ._models import CameraModel, PartModel, load_camera, load_parts
from ._overlay import overlay
from ._results import FrameEstimate, PoseEstimate, PoseStatus, Roi
from ._streams import Pipeline, Stream, stream
from ._table import to_table

__all__ = [
    "CameraModel", "DeviceError", "Error", "Estimator", "FrameEstimate", "InputError", "OpenclDevice", "OutputError",
    "PartModel", "Pipeline", "PoseEstimate", "PoseStatus", "Roi", "Stream", "__version__", "backends", "devices",
    "load_camera", "load_parts", "overlay", "stream", "to_table",
]

# Where people meet them; their modules are nobody's business.
for _name in __all__:
    if hasattr(globals()[_name], "__module__"):
        globals()[_name].__module__ = __name__
del _name
