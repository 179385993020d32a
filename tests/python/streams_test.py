"""stream() and Pipeline: order, ends, failures."""

import csv
import gc
import io
import os
import shutil
import signal
import subprocess
import sys
import threading
import unittest
import weakref

import numpy as np

import cylpose
import scene


def threads():
    return len(os.listdir("/proc/self/task"))


def open_stream(frames=None, inputs=None, **options):
    frames = frames or scene.sequence()
    return cylpose.stream(frames.frames if inputs is None else inputs, frames.camera, frames.parts, backend="serial", **options)


def small_pipeline(**options):
    _, camera, parts = scene.small_view()
    return cylpose.Pipeline(camera, parts, backend="serial", **options)


class Streams(unittest.TestCase):
    def assert_equals_csv(self, results, text):
        rows = list(csv.DictReader(io.StringIO(text)))
        table = cylpose.to_table(results)
        self.assertEqual(list(table.dtype.names), list(rows[0]))
        self.assertEqual(len(table), len(rows))
        for row, wanted in zip(table, rows):
            self.assertEqual([str(row["frame"]), row["part"], row["status"]],
                             [wanted["frame"], wanted["part"], wanted["status"]])
            for name in table.dtype.names:
                if name not in ("frame", "part", "status"):
                    np.testing.assert_equal(row[name], float(wanted[name] or "nan"), name)

    def test_of_images_a_folder_and_a_video_equal_the_command(self):
        frames = scene.sequence()
        for inputs in (frames.frames, frames.files, frames.files[0].parent, frames.video):
            words = inputs if isinstance(inputs, list) else [inputs]
            results = list(open_stream(inputs=inputs))
            self.assertEqual({part.status for result in results for part in result.parts}, {"ok"})
            self.assert_equals_csv(results, frames.results(*words))

    def test_filtered_equal_the_command(self):
        frames = scene.sequence("occlusion", 20)
        hidden = scene.folder() / "hidden.png"
        scene.Image.fromarray(np.full_like(frames.rgb(0), 128)).save(hidden)
        files = [*frames.files[:12], hidden, hidden, *frames.files[14:]]
        results = list(open_stream(frames, inputs=files, filter=True))
        self.assertEqual([result.parts[0].status for result in results[12:14]], ["predicted"] * 2)
        self.assert_equals_csv(results, frames.results("--filter", *files))

    def test_names_times_and_rates(self):
        frames = scene.sequence()
        results = list(open_stream(fps=8))
        self.assertEqual([result.name for result in results], list(map(str, frames.files)))
        self.assertEqual([result.timestamp_s for result in results], [i / 8 for i in range(len(results))])

    def test_images_come_along_on_request(self):
        frames = scene.sequence()
        self.assertIsNone(next(open_stream()).image)
        results = list(open_stream(images=True))
        gc.collect()  # the stream is gone, its images are not
        for i, result in enumerate(results):
            np.testing.assert_array_equal(result.image, frames.bgr(i))

    def test_live_delivers_newer_frames_only_in_order(self):
        stream = open_stream(live=True, fps=100)
        numbers = [result.frame for result in stream]
        self.assertEqual(numbers, sorted(set(numbers)))
        self.assertEqual(len(numbers) + stream.dropped, len(scene.sequence().files))

    def test_several_go_on_side_by_side(self):
        pairs = list(zip(open_stream(), open_stream(), strict=True))
        self.assertEqual(len(pairs), len(scene.sequence().files))
        for one, other in pairs:
            np.testing.assert_array_equal(one.parts[0].covariance, other.parts[0].covariance)


class Ends(unittest.TestCase):
    def setUp(self):
        list(open_stream())  # oneTBB starts its threads
        self.threads = threads()

    def assert_all_ended(self, stream):
        self.assertIsNone(stream())
        self.assertLessEqual(threads(), self.threads)

    def test_leaving_the_loop_ends_the_work(self):
        stream = open_stream()
        held = weakref.ref(stream)
        for result in stream:
            self.assertEqual(result.frame, 0)
            break
        del stream
        self.assert_all_ended(held)

    def test_an_exception_in_the_loop_goes_out_and_ends_the_work(self):
        held = []
        with self.assertRaisesRegex(KeyError, "mine"):
            with open_stream() as stream:
                held.append(weakref.ref(stream))
                for _ in stream:
                    raise KeyError("mine")
        del stream
        self.assert_all_ended(held[0])

    def test_close_is_final_and_can_be_repeated(self):
        stream = open_stream()
        next(stream)
        stream.close()
        stream.close()
        self.assertEqual(list(stream), [])
        self.assertLessEqual(threads(), self.threads)

    def test_close_from_another_thread_ends_a_wait(self):
        pipeline = small_pipeline()
        closer = threading.Timer(0.05, pipeline.close)
        closer.start()
        self.assertEqual(list(pipeline), [])
        closer.join()

    def test_a_signal_ends_a_wait(self):
        class Alarm(Exception):
            pass

        def ring(*_):
            raise Alarm

        self.addCleanup(signal.signal, signal.SIGALRM, signal.signal(signal.SIGALRM, ring))
        signal.setitimer(signal.ITIMER_REAL, 0.05)
        with self.assertRaises(Alarm):
            next(small_pipeline())

    def test_the_program_may_end_in_the_middle(self):
        frames = scene.sequence()
        program = ("import cylpose, sys\n"
                   "frames, camera, parts = sys.argv[1:]\n"
                   "stream = cylpose.stream(frames, camera, parts, backend='serial', live=True, fps=1)\n"
                   "next(stream)\n"
                   "pipeline = cylpose.Pipeline(camera, parts, backend='serial')\n"
                   "for result in cylpose.stream(frames, camera, parts, backend='serial', images=True):\n"
                   "  pipeline.put(result.image, result.timestamp_s)\n"
                   "print('end')\n")
        ended = subprocess.run([sys.executable, "-c", program, frames.frames, frames.camera, frames.parts],
                               capture_output=True, text=True, timeout=60)
        self.assertEqual((ended.returncode, ended.stdout, ended.stderr), (0, "end\n", ""))


class Failures(unittest.TestCase):
    def test_what_cannot_be_opened_is_refused_at_once(self):
        for inputs, text in (("no_such.mp4", "no_such.mp4: no such file"), ([], "no input")):
            with self.assertRaisesRegex(cylpose.InputError, text):
                open_stream(inputs=inputs)
        for options, text in (({"fps": 0}, "fps is 0"), ({"lag": 65}, "lag is 65"), ({"lag": -1}, "lag is -1")):
            with self.assertRaisesRegex(cylpose.InputError, text):
                open_stream(**options)

    def test_a_missing_camera_is_a_device_error(self):
        with self.assertRaisesRegex(cylpose.DeviceError, "camera 999"):
            open_stream(inputs="999")

    def test_an_unreadable_file_is_a_result_and_the_stream_goes_on(self):
        frames = scene.sequence()
        copies = scene.folder() / "damaged"
        copies.mkdir()
        for file in frames.files[:3]:
            shutil.copy(file, copies)
        damaged = copies / frames.files[1].name
        damaged.write_bytes(b"no picture")
        results = list(open_stream(inputs=copies, images=True))
        self.assertEqual([result.parts[0].status for result in results], ["ok", "none", "ok"])
        self.assertEqual([bool(result.error) for result in results], [False, True, False])
        self.assertIn(str(damaged), results[1].error)
        self.assertEqual(results[1].parts[0].reason, results[1].error)
        self.assertIsNone(results[1].image)

    def test_files_may_have_names_in_any_encoding(self):
        frames = scene.sequence()
        file = os.fsencode(scene.folder()) + b"/\xff.png"
        with open(file, "wb") as damaged:
            damaged.write(b"no picture")
        result, = cylpose.stream(os.fsdecode(file), frames.camera, frames.parts, backend="serial")
        self.assertEqual(result.name, os.fsdecode(file))
        self.assertIn(os.fsdecode(file), result.parts[0].reason)
        with self.assertRaisesRegex(cylpose.InputError, "no_\udcff.yaml"):
            cylpose.load_camera("no_\udcff.yaml")

    def test_frames_of_another_size_raise_behind_the_good_ones(self):
        frames = scene.sequence()
        small = scene.folder() / "small.png"
        scene.Image.fromarray(frames.rgb(0)[:100]).save(small)
        results = []
        with self.assertRaisesRegex(cylpose.InputError, f"{small}: image is 1280 x 100 pixels but the camera"):
            for result in open_stream(inputs=[frames.files[0], frames.files[1], small]):
                results.append(result.frame)
        self.assertEqual(results, [0, 1])

    def test_a_video_cut_short_is_told(self):
        frames = scene.sequence("occlusion", 20)
        cut = scene.folder() / ("cut" + frames.video.suffix)
        whole = frames.video.read_bytes()
        moov = whole.rfind(b"moov")
        # The index stays, most pictures go.
        cut.write_bytes(whole[:moov // 4] + bytes(moov - moov // 4) + whole[moov:])
        stream = open_stream(frames, inputs=cut)
        count = sum(1 for _ in stream)
        self.assertLess(count, 20)
        self.assertIn("cut short or damaged", stream.warnings[0])


class Pipelines(unittest.TestCase):
    def test_results_are_those_of_the_estimator_in_order(self):
        image, _, _ = scene.small_view()
        estimator = scene.small_estimator()
        pipeline = small_pipeline(lag=1)
        results = []
        for i in range(20):
            self.assertEqual(pipeline.put(image, i / 10), i)
            results += pipeline.ready()
        pipeline.finish()
        results += pipeline
        self.assertEqual([(result.frame, result.timestamp_s) for result in results], [(i, i / 10) for i in range(20)])
        for result in results:
            expected = estimator.estimate(image)
            self.assertEqual(result.searched, expected.searched)
            np.testing.assert_array_equal(result.parts[0].covariance, expected.parts[0].covariance)
        self.assertEqual((list(pipeline), list(pipeline.ready())), ([], []))

    def test_one_thread_puts_and_another_takes(self):
        image, _, _ = scene.small_view()
        with small_pipeline() as pipeline:
            def put_all():
                for i in range(50):
                    pipeline.put(image, i)
                pipeline.finish()

            putter = threading.Thread(target=put_all)
            putter.start()
            self.assertEqual([result.frame for result in pipeline], list(range(50)))
            putter.join()

    def test_images_are_held_while_in_use_and_not_longer(self):
        image, _, _ = scene.small_view()
        before = sys.getrefcount(image)
        pipeline = small_pipeline()
        for i in range(200):
            pipeline.put(image, i)
            for _ in pipeline.ready():
                pass
        pipeline.finish()
        self.assertGreater(len(list(pipeline)), 0)
        self.assertEqual(sys.getrefcount(image), before)
        pipeline = small_pipeline(live=True)
        for i in range(200):
            pipeline.put(image, i)
        pipeline.close()
        self.assertEqual(sys.getrefcount(image), before)

    def test_an_image_that_only_the_pipeline_holds_stays(self):
        image, _, _ = scene.small_view()
        expected = scene.small_estimator().estimate(image).parts[0].center_in_cam
        pipeline = small_pipeline()
        for i in range(20):
            pipeline.put(image.copy(), i)
            np.zeros(image.shape, np.uint8)  # would take the place of one given back
        pipeline.finish()
        for result in pipeline:
            np.testing.assert_allclose(result.parts[0].center_in_cam, expected, atol=1e-4)

    def test_what_is_refused(self):
        image, _, _ = scene.small_view()
        pipeline = small_pipeline()
        with self.assertRaisesRegex(cylpose.InputError, "image is 320 x 10 pixels but"):
            pipeline.put(image[:10], 0)
        with self.assertRaisesRegex(cylpose.InputError, "timestamp_s is not finite"):
            pipeline.put(image, float("nan"))
        self.assertEqual(pipeline.put(image, 0), 0)
        pipeline.finish()
        for end in (pipeline.finish, pipeline.close):
            end()
            with self.assertRaisesRegex(cylpose.InputError, "takes no frames after finish or close"):
                pipeline.put(image, 1)

    def test_time_that_goes_back_raises_from_the_iterator(self):
        image, _, _ = scene.small_view()
        pipeline = small_pipeline(filter=True)
        pipeline.put(image, 1.0)
        pipeline.put(image, 0.5)
        pipeline.finish()
        self.assertEqual(next(pipeline).frame, 0)
        with self.assertRaisesRegex(cylpose.InputError, "frame 1: "):
            next(pipeline)


if __name__ == "__main__":
    unittest.main()
