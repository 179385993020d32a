"""Rendered sequences, made once per test program, and the command's answers to them."""

import atexit
import functools
import os
import pathlib
import shutil
import subprocess
import tempfile

import numpy as np
from PIL import Image

import cylpose

COMMAND = os.environ["CYLPOSE_COMMAND"]
# A sanitizer's runtime for the interpreter is none for the command, which has its own.
ENVIRONMENT = {name: value for name, value in os.environ.items() if name != "LD_PRELOAD"}


@functools.cache
def folder():
    path = pathlib.Path(tempfile.mkdtemp(prefix="cylpose_python_"))
    atexit.register(shutil.rmtree, path)
    return path


def run(*arguments):
    return subprocess.run([COMMAND, *map(str, arguments)], check=True, capture_output=True, text=True,
                          env=ENVIRONMENT).stdout


class Sequence:
    """Frames of a scenario, with the files that belong to them."""

    def __init__(self, path):
        self.camera = path / "camera.yaml"
        self.parts = path / "parts.yaml"
        self.frames = str(path / "frame_%04d.png")
        self.files = sorted(path.glob("frame_*.png"))
        self.video = next(path.glob("video.*"))

    def rgb(self, index):
        return np.asarray(Image.open(self.files[index]))

    def bgr(self, index):
        return np.ascontiguousarray(self.rgb(index)[..., ::-1])

    def results(self, *options):
        """What `cylpose estimate` writes, by its file's extension."""
        return run("estimate", "--camera", self.camera, "--parts", self.parts, "--backend", "serial", *options)


@functools.cache
def sequence(scenario="series3", frames=6):
    path = folder() / scenario
    run("synth", scenario, "--frames", frames, "--video", "--output", path)
    return Sequence(path)


@functools.cache
def small_view():
    """(image, camera, parts): a crop around the cylinder of a frame, as a view of the frame, and the camera that sees it."""
    frames = sequence()
    camera = cylpose.load_camera(frames.camera)
    x, y, width, height = 480, 200, 320, 320
    image = frames.bgr(0)[y:y + height, x:x + width]
    cropped = cylpose.CameraModel(width, height, camera.fx, camera.fy, camera.cx - x, camera.cy - y)
    return image, cropped, cylpose.load_parts(frames.parts)


def small_estimator():
    _, camera, parts = small_view()
    return cylpose.Estimator(camera, parts, backend="serial")
