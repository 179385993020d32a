"""Estimator: the poses of the command, and what is refused."""

import json
import math
import pathlib
import unittest

import numpy as np

import cylpose
import scene


class Poses(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        frames = scene.sequence()
        cls.estimator = cylpose.Estimator(frames.camera, frames.parts, backend="serial")
        cls.results = [cls.estimator.estimate(frames.bgr(i)) for i in range(len(frames.files))]

    def test_are_those_of_the_stream_without_lag(self):
        frames = scene.sequence()
        for result, streamed in zip(self.results, cylpose.stream(frames.frames, frames.camera, frames.parts,
                                                                 backend="serial", lag=1), strict=True):
            part, other = result.parts[0], streamed.parts[0]
            self.assertEqual(part.status, "ok")
            self.assertEqual(result.searched, streamed.searched)
            for name in ("center_in_cam", "axis_in_cam", "covariance", "sides"):
                np.testing.assert_array_equal(getattr(part, name), getattr(other, name), name)
            self.assertEqual((part.rms_px, part.support, part.seen), (other.rms_px, other.support, other.seen))

    def test_hold_all_that_the_command_writes(self):
        frames = scene.sequence()
        # One frame alone, so that the command's lag has no meaning.
        row = json.loads(frames.results("--format", "jsonl", frames.files[0]))
        part = self.results[0].parts[0]
        self.assertEqual(part.name, row["part"])
        np.testing.assert_array_equal(part.center_in_cam, row["center_m"])
        np.testing.assert_array_equal(part.axis_in_cam, row["axis"])
        np.testing.assert_array_equal(part.covariance.ravel(), row["covariance"])
        np.testing.assert_array_equal(part.sigma_center_m, row["sigma_center_m"])
        self.assertEqual((part.sigma_axis_deg, part.rms_px, part.support, part.seen),
                         (row["sigma_axis_deg"], row["rms_px"], row["support"], row["seen"]))

    def test_are_the_same_on_every_exact_backend(self):
        frames = scene.sequence()
        image = frames.bgr(0)
        self.assertIn("serial", cylpose.backends())
        for backend in {"default", "opencl"} & (cylpose.backends().keys() | {"default"}):
            other = cylpose.Estimator(frames.camera, frames.parts, backend=backend).estimate(image)
            np.testing.assert_array_equal(other.parts[0].covariance, self.results[0].parts[0].covariance, backend)

    def test_the_frame_is_described(self):
        first, second = self.results[:2]
        self.assertEqual((first.frame, second.frame), (0, 1))
        self.assertTrue(math.isnan(first.timestamp_s))
        self.assertEqual(first.searched, (0, 0, 1280, 720))
        self.assertLess(second.searched.width, 1280)
        self.assertGreater(second.times_ms["gate"], 0)
        self.assertIsNone(first.image)

    def test_nothing_there_is_none_with_the_reason_and_nan(self):
        frames = scene.sequence()
        part = cylpose.Estimator(frames.camera, frames.parts, backend="serial").estimate(
            np.full((720, 1280, 3), 90, np.uint8)).parts[0]
        self.assertIs(part.status, cylpose.PoseStatus.NONE)
        self.assertIn("colour", part.reason)
        for name in ("center_in_cam", "axis_in_cam", "covariance", "sigma_center_m", "sides"):
            self.assertTrue(np.isnan(getattr(part, name)).all(), name)
        self.assertTrue(math.isnan(part.sigma_axis_deg) and math.isnan(part.rms_px))

    def test_reset_searches_the_whole_image_again(self):
        image, _, _ = scene.small_view()
        estimator = scene.small_estimator()
        whole = estimator.estimate(image).searched
        self.assertEqual(whole, (0, 0, 320, 320))
        self.assertNotEqual(estimator.estimate(image).searched, whole)
        estimator.reset()
        again = estimator.estimate(image)
        self.assertEqual((again.searched, again.frame), (whole, 0))


class Models(unittest.TestCase):
    def test_are_what_the_files_say(self):
        frames = scene.sequence()
        self.assertEqual(cylpose.load_camera(str(frames.camera)),
                         cylpose.CameraModel(1280, 720, 1215, 1215, 639.5, 359.5, "none", (), "srgb"))
        part, = cylpose.load_parts(frames.parts)
        self.assertEqual((part.radius_m, part.height_m), (0.05, 0.4))
        self.assertEqual(len(part.hue_deg), 2)

    def test_distortion_and_transfer_reach_the_library(self):
        image, camera, parts = scene.small_view()

        def center(**changes):
            values = {name: getattr(camera, name) for name in camera.__dataclass_fields__} | changes
            part, = cylpose.Estimator(cylpose.CameraModel(**values), parts, backend="serial").estimate(image).parts
            self.assertEqual(part.status, "ok", part.reason)
            return part.center_in_cam

        plain = center()
        for changes in ({"distortion_model": "plumb_bob", "distortion": (0.01, 0, 0, 0, 0)},
                        {"distortion_model": "equidistant", "distortion": [0.01, 0, 0, 0]}, {"transfer": "linear"}):
            self.assertGreater(np.linalg.norm(center(**changes) - plain), 1e-6, changes)
        np.testing.assert_allclose(
            center(distortion_model="rational_polynomial", distortion=(0.01, 0, 0, 0, 0, 0, 0, 0)),
            center(distortion_model="plumb_bob", distortion=(0.01, 0, 0, 0, 0)), atol=1e-9)


class Refusals(unittest.TestCase):
    def assert_refused(self, kind, text, call, *arguments, **options):
        with self.assertRaises(kind) as caught:
            call(*arguments, **options)
        self.assertIs(type(caught.exception), kind)
        self.assertIn(text, str(caught.exception))

    def test_files(self):
        frames = scene.sequence()
        self.assert_refused(cylpose.InputError, "no_such.yaml", cylpose.Estimator, "no_such.yaml", frames.parts)
        self.assert_refused(cylpose.InputError, "no_such.yaml", cylpose.load_parts, pathlib.Path("no_such.yaml"))
        self.assert_refused(cylpose.InputError, "camera.yaml", cylpose.load_parts, frames.camera)

    def test_text_is_the_command_s(self):
        bad = scene.folder() / "bad.yaml"
        bad.write_text("parts:\n  - {name: a, radius_m: -1, height_m: 1, hue_deg: [0, 20]}\n")
        with self.assertRaises(cylpose.InputError) as caught:
            cylpose.load_parts(bad)
        frames = scene.sequence()
        with self.assertRaises(scene.subprocess.CalledProcessError) as command:
            scene.run("estimate", "--camera", frames.camera, "--parts", bad, frames.files[0])
        self.assertEqual(command.exception.stderr, f"cylpose: {caught.exception}\n")

    def test_values_and_names(self):
        image, camera, parts = scene.small_view()
        uncalibrated = cylpose.CameraModel(320, 320, 0, 0, 160, 160)
        flat = cylpose.PartModel("flat", 0.05, 0, (0, 20))
        for text, arguments, options in (
                ("focal length", (uncalibrated, parts), {}),
                ("part 'flat'", (camera, [flat]), {}),
                ("no part to look for", (camera, []), {}),
                ("there is no backend 'gpu'", (camera, parts), {"backend": "gpu"}),
                ("device 'cpu': only the backend opencl", (camera, parts), {"backend": "serial", "device": "cpu"}),
                ("unknown distortion_model 'fish'", (cylpose.CameraModel(9, 9, 9, 9, 4, 4, "fish"), parts), {}),
                ("unknown transfer 'rec709'", (cylpose.CameraModel(9, 9, 9, 9, 4, 4, transfer="rec709"), parts), {})):
            self.assert_refused(cylpose.InputError, text, cylpose.Estimator, *arguments, **options)
        self.assert_refused(TypeError, "CameraModel.width is 'wide'; it must be a whole number", cylpose.Estimator,
                            cylpose.CameraModel("wide", 9, 9, 9, 4, 4), parts)
        self.assert_refused(TypeError, "PartModel.hue_deg is 20; it must be two numbers", cylpose.Estimator, camera,
                            [cylpose.PartModel("a", 0.1, 0.1, 20)])

    def test_errors_are_caught_by_kind_and_in_python_s_way(self):
        for kind in (cylpose.InputError, cylpose.OutputError, cylpose.DeviceError):
            self.assertTrue(issubclass(kind, cylpose.Error))
        self.assertTrue(issubclass(cylpose.InputError, ValueError))


if __name__ == "__main__":
    unittest.main()
