"""What Python adds to Estimator::estimate: both on the same images in turn, in one run.

overhead.py COMMAND [FRAMES]      COMMAND: the cylpose command, which renders the images
"""

import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

import cylpose
import cylpose_overhead


def measure(backend, camera, parts, images, frames):
    native = cylpose_overhead.TimedEstimator(camera, parts, backend)
    python = cylpose.Estimator(camera, parts, backend)
    native_us, python_us = [], []
    for i in range(frames):
        image = images[i % len(images)]

        def run_native():
            native_us.append(native.estimate_us(image))

        def run_python():
            start = time.perf_counter_ns()
            result = python.estimate(image)
            python_us.append((time.perf_counter_ns() - start) / 1000)
            assert result.parts[0].status == "ok", result.parts[0].reason

        # Whoever comes second finds the image in the cache: take turns.
        for run in (run_native, run_python) if i % 2 else (run_python, run_native):
            run()
    warm = frames // 10
    return native_us[warm:], python_us[warm:]


def main(command, frames=2000):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        # The smallest pictures of the part, some 5 m away: little to do for C++, all of it for Python.
        subprocess.run([command, "synth", "series1", "--frames", "50", "--output", folder], check=True, capture_output=True)
        camera, parts = folder / "camera.yaml", folder / "parts.yaml"
        files = [folder / f"frame_{i:04d}.png" for i in range(4)]
        images = [result.image for result in cylpose.stream(files, camera, parts, backend="serial", images=True)]
        print(f"{frames} frames of 1280x720 each, medians in us")
        print(f"{'backend':10}{'C++':>10}{'Python':>10}{'difference':>12}{'of pairs':>10}")
        for backend in sorted(cylpose.backends().keys() & {"serial", "opencl"}):
            native_us, python_us = measure(backend, camera, parts, images, int(frames))
            pairs = statistics.median(python - native for native, python in zip(native_us, python_us))
            native, python = statistics.median(native_us), statistics.median(python_us)
            print(f"{backend:10}{native:10.1f}{python:10.1f}{python - native:12.1f}{pairs:10.1f}")


if __name__ == "__main__":
    main(*sys.argv[1:])
