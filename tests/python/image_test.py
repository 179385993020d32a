"""NumPy arrays as images: which are taken, as what, and that none is copied."""

import ctypes
import gc
import mmap
import subprocess
import sys
import tracemalloc
import unittest

import numpy as np

import cylpose
import scene


def same_pose(a, b):
    return a.parts[0].status == b.parts[0].status == "ok" and np.array_equal(a.parts[0].covariance, b.parts[0].covariance)


class Arrays(unittest.TestCase):
    def setUp(self):
        self.image, self.camera, self.parts = scene.small_view()
        self.expected = scene.small_estimator().estimate(np.ascontiguousarray(self.image))

    def test_views_with_row_strides_are_images(self):
        self.assertFalse(self.image.flags.c_contiguous)
        self.assertTrue(same_pose(scene.small_estimator().estimate(self.image), self.expected))
        every_second_row = np.repeat(self.image, 2, axis=0)[::2]
        self.assertTrue(same_pose(scene.small_estimator().estimate(every_second_row), self.expected))

    def test_the_order_of_the_channels_can_be_chosen(self):
        rgb = np.ascontiguousarray(self.image[..., ::-1])
        self.assertTrue(same_pose(scene.small_estimator().estimate(rgb, "rgb"), self.expected))
        self.assertFalse(same_pose(scene.small_estimator().estimate(rgb), self.expected))

    def test_grey_and_read_only_arrays_are_images(self):
        grey = np.ascontiguousarray(self.image[..., 0])
        for image in (grey, grey[..., np.newaxis]):
            self.assertEqual(scene.small_estimator().estimate(image).parts[0].status, "none")
        self.image.flags.writeable = False
        self.addCleanup(self.image.setflags, write=True)
        self.assertTrue(same_pose(scene.small_estimator().estimate(self.image), self.expected))

    def test_other_arrays_are_refused_with_shape_and_remedy(self):
        wanted = "cylpose takes 8-bit images of 1 or 3 channels"
        estimator = scene.small_estimator()
        for text, image in (
                ("array of float64 of shape (320, 320, 3); " + wanted, self.image.astype(float)),
                ("array of uint16 of shape (320, 320, 3); " + wanted, self.image.astype(np.uint16)),
                ("array of uint8 of shape (320, 320, 4); " + wanted, np.zeros((320, 320, 4), np.uint8)),
                ("array of uint8 of shape (320,); " + wanted, np.zeros(320, np.uint8)),
                ("array of uint8 of shape (1, 320, 320, 3); " + wanted, self.image[np.newaxis]),
                ("image is empty", self.image[:0]),
                ("side by side: give numpy.ascontiguousarray(image)", self.image[:, ::-1]),
                ("or color_order for another order of the channels", self.image[..., ::-1]),
                ("image stride of -", self.image[::-1]),
                ("image stride of 0 bytes", np.broadcast_to(self.image[0], self.image.shape)),
                ("too large", np.broadcast_to(np.zeros(1, np.uint8), (40000, 1))),
                ("image is 320 x 100 pixels but the camera was calibrated at 320 x 320; use images of that size or "
                 "calibrate again", self.image[:100])):
            with self.subTest(text), self.assertRaises(cylpose.InputError) as caught:
                estimator.estimate(image)
            self.assertIn(text, str(caught.exception))
        with self.assertRaisesRegex(cylpose.InputError, "unknown color_order 'gbr'; write bgr or rgb"):
            estimator.estimate(self.image, "gbr")
        with self.assertRaisesRegex(TypeError, "image is a list; give a NumPy array"):
            estimator.estimate(self.image.tolist())
        self.assertTrue(same_pose(estimator.estimate(self.image), self.expected))  # none of them did any harm


class Memory(unittest.TestCase):
    def test_pixels_are_not_copied(self):
        # A copy would read the whole image, and only the search region can be read here.
        ended = subprocess.run([sys.executable, __file__, "estimate-in-guarded-memory"], capture_output=True, text=True)
        self.assertEqual((ended.returncode, ended.stdout), (0, "ok\n"), ended.stderr)

    def test_nothing_is_kept_of_two_thousand_calls(self):
        image, _, _ = scene.small_view()
        estimator = scene.small_estimator()
        words = (cylpose.PoseStatus.OK, cylpose.PoseEstimate, cylpose.FrameEstimate, cylpose.Roi, np.dtype(float))

        def counts():
            gc.collect()
            return [sys.getrefcount(thing) for thing in (image, estimator, *words)]

        def calls(count):
            for _ in range(count):
                estimator.estimate(image)
                with self.assertRaises(cylpose.InputError):
                    estimator.estimate(image[:10])

        calls(20)
        tracemalloc.start()
        self.addCleanup(tracemalloc.stop)
        before, memory_before = counts(), tracemalloc.get_traced_memory()[0]
        calls(2000)
        for thing, old, new in zip(("image", "estimator", *words), before, counts(), strict=True):
            self.assertLess(abs(new - old), 20, thing)  # far from one per call
        self.assertLess(tracemalloc.get_traced_memory()[0] - memory_before, 20000)

    def test_results_are_the_caller_s(self):
        image, _, _ = scene.small_view()
        estimator = scene.small_estimator()
        part = estimator.estimate(image).parts[0]
        kept = part.covariance.copy()
        del estimator
        self.assertTrue(part.covariance.flags.owndata)
        np.testing.assert_array_equal(part.covariance, kept)


def estimate_in_guarded_memory():
    frames = scene.sequence()
    pixels = frames.bgr(0)
    memory = mmap.mmap(-1, pixels.nbytes)
    image = np.frombuffer(memory, np.uint8).reshape(pixels.shape)
    image[:] = pixels
    estimator = cylpose.Estimator(frames.camera, frames.parts, backend="serial")
    estimator.estimate(image)
    searched = estimator.estimate(image).searched
    # Whole pages above and below the rows that are searched next.
    row = image.strides[0]
    above = searched.y * row // mmap.PAGESIZE * mmap.PAGESIZE
    below = -(-(searched.y + searched.height) * row // mmap.PAGESIZE) * mmap.PAGESIZE
    protect = ctypes.CDLL(None, use_errno=True).mprotect
    protect.argtypes = (ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int)
    for first, end in ((0, above), (below, pixels.nbytes)):
        assert end > first, "the region is the whole image"
        assert protect(image.ctypes.data + first, end - first, 0) == 0, ctypes.get_errno()
    print(estimator.estimate(image).parts[0].status)


if __name__ == "__main__":
    if sys.argv[1:] == ["estimate-in-guarded-memory"]:
        estimate_in_guarded_memory()
    else:
        unittest.main()
