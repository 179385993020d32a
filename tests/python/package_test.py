"""The package as Python sees it: types, stubs, pickles, the table."""

import ast
import copy
import dataclasses
import inspect
import pathlib
import pickle
import re
import typing
import unittest

import numpy as np

import cylpose
from cylpose import _cylpose
import scene


class Results(unittest.TestCase):
    def setUp(self):
        self.result = scene.small_estimator().estimate(scene.small_view()[0])

    def test_can_be_pickled_and_copied(self):
        for other in (pickle.loads(pickle.dumps(self.result)), copy.deepcopy(self.result)):
            self.assertEqual((other.frame, other.searched, other.times_ms),
                             (self.result.frame, self.result.searched, self.result.times_ms))
            self.assertIs(other.parts[0].status, cylpose.PoseStatus.OK)
            np.testing.assert_array_equal(other.parts[0].covariance, self.result.parts[0].covariance)
            self.assertEqual(repr(cylpose.to_table([other])), repr(cylpose.to_table([self.result])))
        for model in scene.small_view()[1:]:
            self.assertEqual(pickle.loads(pickle.dumps(model)), model)
        error = pickle.loads(pickle.dumps(cylpose.DeviceError("gone")))
        self.assertEqual((type(error), str(error)), (cylpose.DeviceError, "gone"))

    def test_cannot_be_changed(self):
        with self.assertRaises(dataclasses.FrozenInstanceError):
            self.result.frame = 1
        with self.assertRaises(dataclasses.FrozenInstanceError):
            self.result.parts[0].center_in_cam = None

    def test_show_themselves(self):
        text = repr(self.result)
        self.assertIn("center_in_cam=array([", text)
        self.assertIn("status=<PoseStatus.OK: 'ok'>", text)
        self.assertNotIn("covariance", text)
        self.assertEqual(str(self.result.parts[0].status), "ok")

    def test_arrays_are_float64_of_the_shapes_told(self):
        part = self.result.parts[0]
        shapes = {"center_in_cam": (3,), "axis_in_cam": (3,), "covariance": (6, 6), "sigma_center_m": (3,), "sides": (2, 3)}
        for name, shape in shapes.items():
            self.assertEqual((getattr(part, name).shape, getattr(part, name).dtype), (shape, np.float64), name)
        np.testing.assert_allclose(np.linalg.norm(part.axis_in_cam), 1)
        np.testing.assert_allclose(np.linalg.norm(part.sides[:, :2], axis=1), 1)
        np.testing.assert_allclose(part.sigma_center_m**2, part.covariance.diagonal()[:3])


class Table(unittest.TestCase):
    def test_has_a_row_per_frame_and_part(self):
        image, camera, parts = scene.small_view()
        absent = dataclasses.replace(parts[0], name="a part of another colour", hue_deg=(80, 140))
        estimator = cylpose.Estimator(camera, [parts[0], absent], backend="serial")
        table = cylpose.to_table(estimator.estimate(image) for _ in range(3))
        self.assertEqual(table["frame"].tolist(), [0, 0, 1, 1, 2, 2])
        self.assertEqual(table["part"].tolist(), [parts[0].name, absent.name] * 3)
        self.assertEqual(table["status"].tolist(), ["ok", "none"] * 3)
        self.assertTrue(np.isfinite(table["cz"][::2]).all())
        self.assertTrue(np.isnan(table["cz"][1::2]).all())

    def test_of_nothing_has_the_columns_and_no_row(self):
        table = cylpose.to_table([])
        self.assertEqual((len(table), table.dtype["cz"]), (0, np.float64))


class Overlay(unittest.TestCase):
    def test_is_the_command_s(self):
        frames = scene.sequence()
        image = frames.bgr(0)
        result = cylpose.Estimator(frames.camera, frames.parts, backend="serial").estimate(image)
        picture = cylpose.overlay(image, frames.camera, frames.parts, result)
        np.testing.assert_array_equal(image, frames.bgr(0))
        frames.results("--overlay", scene.folder() / "overlay", frames.files[0])
        file, = (scene.folder() / "overlay").glob("*.png")
        np.testing.assert_array_equal(picture[..., ::-1], np.asarray(scene.Image.open(file)))

    def test_wants_the_parts_of_the_result(self):
        image, camera, parts = scene.small_view()
        result = scene.small_estimator().estimate(image)
        with self.assertRaises(cylpose.InputError):
            cylpose.overlay(image, camera, parts * 2, result)


class Interface(unittest.TestCase):
    def test_everything_public_is_described_and_found_where_it_is_said_to_be(self):
        for name in cylpose.__all__:
            thing = getattr(cylpose, name)
            if name != "__version__":
                self.assertTrue(inspect.getdoc(thing), name)
                self.assertEqual(thing.__module__, "cylpose", name)
        self.assertRegex(cylpose.__version__, r"^\d+\.\d+\.\d+$")
        self.assertEqual(scene.run("--version").split(), ["cylpose", cylpose.__version__])

    def test_annotations_are_whole(self):
        for name in set(cylpose.__all__) - {"__version__"}:
            thing = getattr(cylpose, name)
            functions = [thing]
            if inspect.isclass(thing):
                functions = [f for _, f in inspect.getmembers(thing, inspect.isfunction)
                             if f.__module__.startswith("cylpose") and (f.__name__ == "__init__" or f.__name__[0] != "_")]
            for function in functions:
                hints = typing.get_type_hints(function)
                for parameter in list(inspect.signature(function).parameters) + ["return"]:
                    if parameter != "self":
                        self.assertIn(parameter, hints, f"{name}.{function.__name__}")
        self.assertTrue((pathlib.Path(cylpose.__file__).parent / "py.typed").exists())

    def test_the_stub_says_what_the_extension_has(self):
        stub = ast.parse((pathlib.Path(cylpose.__file__).parent / "_cylpose.pyi").read_text())

        def arguments(function):
            return [argument.arg for argument in function.args.args]

        def native_arguments(function):
            return re.findall(r"(?:\(|, )(\w+):", function.__doc__.splitlines()[0].partition(" ->")[0])

        told = {node.target.id for node in stub.body if isinstance(node, ast.AnnAssign)}
        for node in stub.body:
            if isinstance(node, ast.FunctionDef):
                told.add(node.name)
                self.assertEqual(arguments(node), native_arguments(getattr(_cylpose, node.name)), node.name)
            elif isinstance(node, ast.ClassDef):
                told.add(node.name)
                native = getattr(_cylpose, node.name)
                for method in node.body:
                    self.assertEqual(arguments(method), native_arguments(getattr(native, method.name)),
                                     f"{node.name}.{method.name}")
                self.assertEqual({method.name for method in node.body},
                                 {name for name in vars(native) if not name.startswith("_")} | {"__init__"})
        self.assertEqual(told, {name for name in vars(_cylpose) if not name.startswith("_")})

    def test_devices_are_described(self):
        for i, device in enumerate(cylpose.devices()):
            self.assertIsInstance(device, cylpose.OpenclDevice)
            self.assertEqual(device.index, i)
            self.assertIn(device.name, scene.run("devices"))


if __name__ == "__main__":
    unittest.main()
