"""The live page as a viewer sees it: the real command, a recording at its own speed, headless Chromium.

live_test.py COMMAND CHROMIUM TIDY [UNITTEST OPTION...]; with PICTURES=DIR in the environment it leaves screenshots.
"""

import csv
import http.client
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import unittest

from chromium import Chromium
from page_checks import FAINT_TEXTS, OVERFLOWING, OVERLAPPING, complaints, requests, tidied
from prometheus_client.parser import text_string_to_metric_families

COMMAND, CHROMIUM, TIDY = map(os.path.abspath, sys.argv[1:4])
WIDTHS = (360, 1280, 1920)

# Resolves when a script's value is true.
UNTIL = """new Promise((done) => {
  const look = () => (%s) ? done(true) : setTimeout(look, 20);
  look();
})"""

# Of what the picture shows: sums that tell two frames apart, and how far from one colour it is.
PICTURE = """(() => {
  const image = document.getElementById("picture");
  const copy = new OffscreenCanvas(64, 36).getContext("2d");
  copy.drawImage(image, 0, 0, 64, 36);
  const pixels = copy.getImageData(0, 0, 64, 36).data;
  return {frame: Number(/frame=(\\d+)/.exec(image.src)?.[1] ?? -1), width: image.naturalWidth, pixels: pixels.join(" "),
          colors: new Set(pixels).size};
})()"""

# What can be used by keyboard or is read out, and has no name.
NAMELESS = """[...document.querySelectorAll("button, a, img, [role=region], table, section")].filter((e) => e.checkVisibility() &&
    !(e.getAttribute("aria-label") || e.alt || e.caption?.textContent || e.textContent.trim() ||
      document.getElementById(e.getAttribute("aria-labelledby"))?.textContent)).map((e) => e.outerHTML.slice(0, 80))"""


def metrics_of(text):
    """{(name, labels as a sorted tuple): value}; the parser fails on what is no exposition."""
    samples = [sample for family in text_string_to_metric_families(text) for sample in family.samples]
    return {(s.name, tuple(sorted(s.labels.items()))): s.value for s in samples}


class Run:
    """A run with --serve. Use as a context manager; ends it as Ctrl-C does."""

    def __init__(self, folder, *inputs, options=()):
        self.poses = os.path.join(folder, "poses.csv")
        self._process = subprocess.Popen(
            [COMMAND, "estimate", "--camera", "scene/camera.yaml", "--parts", "scene/parts.yaml", "--serve", "0",
             "--output", self.poses, *options, *(inputs or ["scene"])], cwd=folder, stderr=subprocess.PIPE, text=True)
        self.said = ""
        while (match := re.search(r"live page: (http://127\.0\.0\.1:(\d+)/)", self.said)) is None:
            line = self._process.stderr.readline()
            if not line:
                raise RuntimeError(self.said)
            self.said += line
        self.url, self.port = match.group(1), int(match.group(2))
        self._reader = threading.Thread(target=self._read_on)
        self._reader.start()

    def _read_on(self):
        self.said += self._process.stderr.read()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.interrupt()

    def interrupt(self):
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)
        return self.wait()

    def wait(self):
        code = self._process.wait(120)
        self._reader.join()
        self._process.stderr.close()
        return code

    def request(self, path, method="GET", body=None):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        connection.request(method, path, body)
        answer = connection.getresponse()
        content = answer.read()
        connection.close()
        return answer.status, content

    def metrics(self):
        status, content = self.request("/metrics")
        if status != 200:
            raise RuntimeError(content)
        return metrics_of(content.decode())


class LiveTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="cylpose_live_")
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.folder = cls.temporary.name
        cls.scene = os.path.join(cls.folder, "scene")
        cls.part = "forearm"
        subprocess.run([COMMAND, "synth", "manipulator", "--frames", "20", "--output", cls.scene], check=True,
                       capture_output=True)
        cls.browser = Chromium(CHROMIUM)
        cls.addClassCleanup(cls.browser.__exit__)

    def stream(self, *options):
        """The recording over and over, as a camera of 20 frames/s would give it."""
        return Run(self.folder, *["scene"] * 500, options=("--live", "--fps", "20", *options))

    def open(self, run, width=1280, scheme="light"):
        self.browser.resize(width, mobile=width < 600)
        self.browser.prefer(scheme)
        self.browser.open(run.url)
        self.until("shownPicture !== null")

    def until(self, condition):
        self.browser.evaluate(UNTIL % condition)

    def text(self, selector):
        return self.browser.evaluate(f"document.querySelector({json.dumps(selector)}).textContent")

    def rows(self, selector):
        """{head: [texts]} of a table."""
        return dict(self.browser.evaluate(
            f"[...document.querySelector({json.dumps(selector)}).tBodies[0].rows].map((row) => "
            "[row.cells[0].textContent, [...row.cells].slice(1).map((cell) => cell.textContent)])"))

    def assert_quiet(self, run):
        self.assertEqual(complaints(self.browser), [])
        outside = [url for url in requests(self.browser) if not url.startswith(run.url)]
        self.assertEqual(outside, [])

    def picture(self, name):
        if "PICTURES" in os.environ:
            os.makedirs(os.environ["PICTURES"], exist_ok=True)
            self.browser.screenshot(os.path.join(os.environ["PICTURES"], name + ".png"))

    def test_shows_a_stream_that_goes_on(self):
        with self.stream() as run:
            self.open(run)
            first = self.browser.evaluate(PICTURE)
            self.assertEqual(first["width"], 1280)
            self.assertGreater(first["colors"], 20)
            self.assertEqual(self.text("#state"), "running")
            self.assertEqual(self.text("#facts li"), "Input: scene, scene, scene, scene and 496 more")
            frame = int(re.search(r"Frame (\d+)", self.text("#caption")).group(1))
            self.until(f"Number(/Frame (\\d+)/.exec(document.getElementById('caption').textContent)[1]) > {frame + 5}")
            self.until(f"{PICTURE}.pixels !== {json.dumps(first['pixels'])}")
            self.assertGreater(self.browser.evaluate(PICTURE)["frame"], first["frame"])
            self.assertRegex(self.text("#rate"), r"^\d+\.\d frames/s, \d+ dropped, latest frame took \d+\.\d ms$")
            pose = self.rows("#parts table")
            self.assertRegex(pose["Centre z [m]"][0], r"^\d\.\d{4}$")
            self.assertRegex(pose["Centre z [m]"][1], r"^± \d+\.\d\d mm$")
            self.assertEqual(self.text("#parts .status"), "ok")
            times = self.rows("#times")
            self.assertIn("solve", times)
            self.assertGreater(float(times["put to sink"][0]), 0)
            self.assertTrue(self.browser.evaluate("document.getElementById('cluster').hidden"))
            self.assert_quiet(run)
            self.assertEqual(run.interrupt(), 130)
            self.assertIn("interrupted, everything up to here is written", run.said)

    def test_reads_at_every_width_in_light_and_dark(self):
        with self.stream() as run:
            for width in WIDTHS:
                for scheme in ("light", "dark"):
                    with self.subTest(width=width, scheme=scheme):
                        self.open(run, width, scheme)
                        self.until("document.getElementById('rate').textContent.includes('frames/s')")
                        self.picture(f"live-{width}-{scheme}")
                        self.assert_quiet(run)
                        self.assertEqual(self.browser.evaluate("document.documentElement.scrollWidth"), width)
                        self.assertEqual(self.browser.evaluate(OVERFLOWING), [])
                        self.assertEqual(self.browser.evaluate(OVERLAPPING), [])
                        self.assertEqual(self.browser.evaluate(NAMELESS), [])
                        texts = self.browser.evaluate(FAINT_TEXTS)
                        self.assertGreater(texts["looked"], 50)
                        self.assertEqual(texts["faint"], [])

    def test_is_valid_html(self):
        with self.stream() as run:
            page = os.path.join(self.folder, "page.html")
            with open(page, "wb") as file:
                file.write(run.request("/")[1])
            self.assertEqual(tidied(TIDY, page), "")

    def test_pauses_by_keyboard(self):
        with self.stream() as run:
            self.open(run)

            def press(key, code):
                for kind in ("keyDown", "keyUp"):
                    self.browser.call("Input.dispatchKeyEvent", type=kind, key=key, code=key,
                                      windowsVirtualKeyCode=code, text="\r" if key == "Enter" else "")
            press("Tab", 9)
            self.assertEqual(self.browser.evaluate("document.activeElement.id"), "pause")
            press("Enter", 13)
            self.assertEqual(self.text("#pause"), "Go on")
            caption = self.text("#caption")
            heard = len([e for e in self.browser.events if e["method"] == "Network.dataReceived"])
            self.browser.evaluate("new Promise((done) => { let n = 0; events.addEventListener('message', () => { if (++n === 4) done(); }); })")
            self.assertEqual(self.text("#caption"), caption, f"paused, but {heard} events")
            press("Enter", 13)
            self.until(f"document.getElementById('caption').textContent !== {json.dumps(caption)}")

    def test_a_recording_ends_with_its_last_frame(self):
        with Run(self.folder, options=("--live", "--fps", "5")) as run:
            self.open(run)
            self.until("events.readyState === EventSource.CLOSED")
            self.assertEqual(run.wait(), 0)
            self.assertEqual(self.text("#state"), "ended")
            self.assertRegex(self.text("#caption"), "^Frame 19 ")
            self.assertEqual(self.browser.evaluate(PICTURE)["frame"], 19)
            self.assert_quiet(run)
            with open(run.poses, encoding="utf-8") as file:
                last = list(csv.DictReader(file))[-1]
            pose = self.rows("#parts table")
            for axis in "xyz":
                self.assertAlmostEqual(float(pose[f"Centre {axis} [m]"][0]), float(last["c" + axis]), delta=6e-5)
            self.assertAlmostEqual(float(pose["Residual [px]"][0]), float(last["rms_px"]), delta=6e-4)

    def test_a_lost_connection_is_said_and_no_end(self):
        with self.stream() as run:
            self.open(run)
            run._process.kill()
            run.wait()
            self.until("document.getElementById('state').textContent === 'connection lost'")

    def test_metrics_are_an_exposition_and_grow(self):
        with self.stream() as run:
            before = run.metrics()
            delivered = ("cylpose_frames_delivered_total", ())
            after = before
            while after[delivered] <= before[delivered] + 3:
                after = run.metrics()
            poses = sum(value for (name, labels), value in after.items()
                        if name == "cylpose_poses_total" and ("part", self.part) in labels)
            later = after
            while later[delivered] <= after[delivered]:
                later = run.metrics()
            # Poses are counted just before their frame, and looked at just after.
            self.assertLessEqual(after[delivered], poses)
            self.assertLessEqual(poses, later[delivered] + 1)
            self.assertEqual(after["cylpose_running", ()], 1)
            self.assertEqual(after["cylpose_frame_latency_seconds_count", ()] >= before[delivered], True)
            median = after["cylpose_node_busy_seconds", (("node", "solve"), ("quantile", "0.5"))]
            self.assertGreater(median, 0)
            self.assertLess(median, 5)
            depth = after["cylpose_part_center_meters", (("axis", "z"), ("part", self.part))]
            self.assertGreater(depth, 0.1)
            self.assertGreater(after["cylpose_part_axis_sigma_radians", (("part", self.part),)], 0)

    def test_shows_the_nodes_of_the_cluster(self):
        if " worker " not in subprocess.run([COMMAND, "--help"], capture_output=True, text=True, check=True).stdout:
            self.skipTest("a build without the cluster")
        ports = os.path.join(self.folder, "ports")
        os.mkdir(ports)
        server = subprocess.Popen(["nats-server", "-a", "127.0.0.1", "-p", "-1", "--ports_file_dir", ports],
                                  stderr=subprocess.DEVNULL)
        self.addCleanup(lambda: (server.kill(), server.wait()))
        while not (files := [f for f in os.listdir(ports) if os.path.getsize(os.path.join(ports, f)) > 0]):
            self.assertIsNone(server.poll())
        with open(os.path.join(ports, files[0]), encoding="utf-8") as file:
            url = json.load(file)["nats"][0]
        worker = subprocess.Popen([COMMAND, "worker", "--server", url, "--name", "lab", "--backend", "serial"],
                                  stderr=subprocess.DEVNULL)
        self.addCleanup(lambda: (worker.terminate(), worker.wait()))
        with self.stream("--backend", "cluster", "--server", url) as run:
            self.open(run)
            self.until("document.querySelector('#nodes tbody')?.textContent.includes('lab.')")
            self.assertFalse(self.browser.evaluate("document.getElementById('cluster').hidden"))
            self.assertEqual(list(self.rows("#tiles")), ["Sent", "Used", "Late", "Refused", "Taken back"])
            self.assertEqual(self.browser.evaluate(OVERFLOWING), [])
            self.picture("live-cluster")
            self.assertEqual(run.metrics()["cylpose_cluster_nodes", ()], 1)
            self.assert_quiet(run)

    def test_nobody_can_write(self):
        with self.stream() as run:
            for method in ("POST", "PUT", "DELETE"):
                self.assertEqual(run.request("/", method, "x" * 1000)[0], 405)

    def test_many_viewers_at_once(self):
        with self.stream() as run:
            while run.metrics()["cylpose_frames_delivered_total", ()] == 0:
                pass
            answers = []

            def look():
                for _ in range(5):
                    try:
                        answers.append(run.request("/picture.jpg")[0])
                    except (ConnectionError, http.client.HTTPException):
                        answers.append(503)  # no connection left
            viewers = [threading.Thread(target=look) for _ in range(40)]
            for viewer in viewers:
                viewer.start()
            for viewer in viewers:
                viewer.join()
            self.assertLessEqual(set(answers), {200, 503})
            self.assertIn(200, answers)
            self.assertEqual(run.request("/picture.jpg")[0], 200)

    def test_says_what_cannot_be_read(self):
        with open(os.path.join(self.folder, "torn.png"), "wb") as file:
            file.write(b"no picture")
        with Run(self.folder, "scene", "torn.png", "scene", options=("--live", "--fps", "10")) as run:
            self.open(run)
            self.until("!document.getElementById('messages').hidden")
            self.assertIn("torn.png", self.text("#messages li"))
            self.until("events.readyState === EventSource.CLOSED")
            self.assertEqual(self.rows("#frames")["Unreadable or failed"], ["1"])
            self.assert_quiet(run)

    def test_a_taken_port_is_refused_before_anything_is_written(self):
        with self.stream() as run:
            output = os.path.join(self.folder, "never.csv")
            other = subprocess.run([COMMAND, "estimate", "--camera", self.scene + "/camera.yaml", "--parts",
                                    self.scene + "/parts.yaml", "--serve", str(run.port), "--output", output, self.scene],
                                   capture_output=True, text=True, check=False)
            self.assertEqual(other.returncode, 3)
            self.assertIn(f"port {run.port}", other.stderr)
            self.assertIn("in use", other.stderr)
            self.assertFalse(os.path.exists(output))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]], verbosity=2)
