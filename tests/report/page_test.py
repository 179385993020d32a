"""The report as a reader sees it: real pages of the real command in headless Chromium.

page_test.py COMMAND CHROMIUM TIDY [UNITTEST OPTION...]; with PICTURES=DIR in the environment it leaves screenshots.
"""

import csv
import json
import math
import os
import random
import re
import subprocess
import sys
import tempfile
import unittest

from chromium import Chromium
from page_checks import FAINT_TEXTS, OVERFLOWING, OVERLAPPING, complaints, requests, tidied

COMMAND, CHROMIUM, TIDY = sys.argv[1:4]
WIDTHS = (360, 1280, 1920)
COLUMNS = ["cx", "cy", "cz", "ax", "ay", "az", "sigma_cx", "sigma_cy", "sigma_cz", "sigma_axis_deg", "rms_px"]

# When all plots are drawn: milliseconds since the page was asked for.
ALL_DRAWN = """new Promise((done) => {
  const look = () => document.documentElement.dataset.drawn ? done(performance.now()) : setTimeout(look, 5);
  look();
})"""

# Per axis of a plot: labels that run into each other.
COLLIDING_TICKS = """[...document.querySelectorAll(".plot")].flatMap((plot) =>
  ["x", "y"].flatMap((axis) => {
    const labels = [...plot.querySelectorAll(".dygraph-axis-label-" + axis)].map((e) => {
      const range = document.createRange();
      range.selectNodeContents(e);
      return range.getBoundingClientRect();
    });
    return labels.flatMap((r, i) => labels.slice(i + 1).filter((s) => Math.min(r.right, s.right) > Math.max(r.left, s.left) &&
        Math.min(r.bottom, s.bottom) > Math.max(r.top, s.top) + 2).map(() => plot.getAttribute("aria-label")));
  }))"""

# Per plot: how many pixels of its canvases or, in print, images are neither empty nor grey like axes and grids.
INKED = """(async () => Promise.all([...document.querySelectorAll(".plot")].map(async (plot) => {
  let inked = 0;
  for (const layer of plot.querySelectorAll("canvas, img")) {
    if (layer.decode) await layer.decode();
    const width = layer.width, height = layer.height;
    const copy = new OffscreenCanvas(width, height).getContext("2d");
    copy.drawImage(layer, 0, 0, width, height);
    const pixels = copy.getImageData(0, 0, width, height).data;
    for (let i = 0; i < pixels.length; i += 4) {
      const [r, g, b, a] = pixels.slice(i, i + 4);
      if (a > 100 && Math.max(r, g, b) - Math.min(r, g, b) > 60) ++inked;
    }
  }
  return [plot.getAttribute("aria-label"), inked];
})))()"""


def run(*words):
    return subprocess.run([COMMAND, *map(str, words)], check=True, capture_output=True, text=True)


def write_recording(folder, count, parts=("link",)):
    """Poses and truth of a made-up flight, with frames that are not found, predicted and missing."""
    generator = random.Random(1)
    poses, truth = os.path.join(folder, "poses.csv"), os.path.join(folder, "truth.csv")
    with open(poses, "w", encoding="utf-8") as out, open(truth, "w", encoding="utf-8") as true_out:
        print("frame,timestamp_s,part,status," + ",".join(COLUMNS), file=out)
        print("frame,part,cx,cy,cz,ax,ay,az", file=true_out)
        for frame in range(count):
            for part in parts:
                angle = 6 * frame / count
                center = [0.3 * math.sin(angle), 0.2 * math.cos(angle), 2 + math.sin(angle / 2)]
                axis = [0.5 * math.sin(angle), -0.8, 0.5 * math.cos(angle)]
                length = math.hypot(*axis)
                print(frame, part, *center, *[a / length for a in axis], sep=",", file=true_out)
                if frame % 50 == 49:
                    continue
                if frame % 20 == 7:
                    print(f"{frame},{frame / 30!r},{part},none" + "," * 11, file=out)
                    continue
                sigmas = [0.0003, 0.0002, 0.002]
                seen = [c + generator.gauss(0, s) for c, s in zip(center, sigmas)]
                tilted = [a + generator.gauss(0, 0.002) for a in axis]
                length = math.hypot(*tilted)
                status = "predicted" if frame % 20 == 8 else "ok"
                print(frame, repr(frame / 30), part, status, *seen, *[a / length for a in tilted], *sigmas, 0.12,
                      abs(generator.gauss(0.15, 0.02)), sep=",", file=out)
    return poses, truth


class PageTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="cylpose_report_")
        cls.addClassCleanup(cls.temporary.cleanup)
        folder = cls.temporary.name
        cls.browser = Chromium(CHROMIUM)
        cls.addClassCleanup(cls.browser.__exit__)

        cls.poses, cls.truth = write_recording(folder, 300)
        cls.compared = os.path.join(folder, "compared.html")
        run("evaluate", cls.truth, cls.poses, "--report", cls.compared)

        scene = os.path.join(folder, "scene")
        run("synth", "fig5.2", "--output", scene)
        cls.estimated = os.path.join(folder, "estimated.html")
        run("estimate", "--camera", scene + "/camera.yaml", "--parts", scene + "/parts.yaml", "--truth",
            scene + "/truth.csv", "--output", folder + "/one.csv", "--report", cls.estimated, scene)

    def open(self, page, width=1280, scheme="light"):
        self.browser.resize(width, mobile=width < 600)
        self.browser.prefer(scheme)
        self.browser.open(page)
        return self.browser.evaluate(ALL_DRAWN)

    def picture(self, name):
        if "PICTURES" in os.environ:
            os.makedirs(os.environ["PICTURES"], exist_ok=True)
            self.browser.screenshot(os.path.join(os.environ["PICTURES"], name + ".png"))

    def assert_quiet(self, page):
        """No error, no message, no request but for the page itself."""
        self.assertEqual(complaints(self.browser), [])
        self.assertEqual(requests(self.browser), ["file://" + page])

    def assert_drawn(self):
        inked = self.browser.evaluate(INKED)
        self.assertGreater(len(inked), 10)
        for label, pixels in inked:
            self.assertGreater(pixels, 8, label)  # a single frame's dot has a dozen

    def frame_range(self):
        return self.browser.evaluate("frames.range")

    def shown_ranges(self):
        """What the plots over frames really show."""
        return self.browser.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => "
                                     "done(frames.plots.map((plot) => plot.graph.xAxisRange())))))")

    def test_reads_at_every_width_in_light_and_dark(self):
        for page in (self.compared, self.estimated):
            for width in WIDTHS:
                for scheme in ("light", "dark"):
                    with self.subTest(page=os.path.basename(page), width=width, scheme=scheme):
                        self.open(page, width, scheme)
                        self.picture(f"{os.path.basename(page)}-{width}-{scheme}")
                        self.assert_quiet(page)
                        self.assert_drawn()
                        self.assertEqual(self.browser.evaluate("document.documentElement.scrollWidth"), width)
                        self.assertEqual(self.browser.evaluate(OVERFLOWING), [])
                        self.assertEqual(self.browser.evaluate(OVERLAPPING), [])
                        self.assertEqual(self.browser.evaluate(COLLIDING_TICKS), [])
                        texts = self.browser.evaluate(FAINT_TEXTS)
                        self.assertGreater(texts["looked"], 100)
                        self.assertEqual(texts["faint"], [])

    def test_is_valid_html(self):
        for page in (self.compared, self.estimated):
            self.assertEqual(tidied(TIDY, page), "")

    def test_its_numbers_are_those_of_the_csv(self):
        with open(self.compared, encoding="utf-8") as file:
            block = re.search(r'<script id="data" type="application/json">(.*?)</script>', file.read(), re.DOTALL)
        data = json.loads(block.group(1))
        self.open(self.compared)
        self.assertEqual(self.browser.evaluate("data.parts[0]"), data["parts"][0], "the page reads the same")
        part = data["parts"][0]
        row_of = {frame: row for row, frame in enumerate(data["frame"])}
        with open(self.poses, encoding="utf-8") as file:
            poses = list(csv.DictReader(file))
        self.assertEqual(len([status for status in part["status"] if status]), len(poses))
        for pose in poses:
            row = row_of[int(pose["frame"])]
            self.assertEqual(part["status"][row], pose["status"])
            self.assertEqual(data["timestamp_s"][row] or 0.0, float(pose["timestamp_s"]))
            for column in COLUMNS:
                self.assertEqual(part[column][row], float(pose[column]) if pose[column] else None)
        with open(self.truth, encoding="utf-8") as file:
            for pose in csv.DictReader(file):
                for column in COLUMNS[:3]:
                    self.assertEqual(part["truth"][column][row_of[int(pose["frame"])]], float(pose[column]))

    def test_what_a_plot_draws_is_what_the_data_says(self):
        self.open(self.compared)
        drawn = self.browser.evaluate("""(() => {
          const plot = frames.plots.find((one) => one.options.title === "Residual (rms)");
          return plot.drawn.map((row, i) => [plot.graph.getValue(i, 0), plot.graph.getValue(i, 1)]);
        })()""")
        with open(self.poses, encoding="utf-8") as file:
            known = {int(row["frame"]): float(row["rms_px"]) for row in csv.DictReader(file) if row["rms_px"]}
        self.assertEqual({x: y for x, y in drawn if y is not None}, known)

    def test_the_keyboard_reads_and_zooms_all_plots(self):
        self.open(self.compared)
        whole = self.frame_range()
        self.browser.evaluate("document.querySelectorAll('.plot')[1].focus()")

        def press(key, code=None, text=None):
            for kind in ("keyDown", "keyUp"):
                self.browser.call("Input.dispatchKeyEvent", type=kind, key=key, code=code or key,
                                  **({"text": text} if text and kind == "keyDown" else {}))

        press("+", text="+")
        zoomed = self.frame_range()
        self.assertAlmostEqual(zoomed[1] - zoomed[0], (whole[1] - whole[0]) / 2)
        for shown in self.shown_ranges():
            self.assertEqual(shown, zoomed)
        press("Home")
        press("ArrowRight")
        said = self.browser.evaluate("document.getElementById('cursor').textContent")
        self.assertRegex(said, r"^Frame 1, 0\.0333333 s · x: estimate -?[0-9.]+, truth [0-9.]+ m$")
        self.assertLess(self.frame_range()[0], 1, "what is read is in sight")
        press("0", text="0")
        self.assertEqual(self.frame_range(), whole)

    def test_tab_reaches_every_plot_and_button(self):
        self.open(self.compared)
        expected = self.browser.evaluate("document.querySelectorAll('.plot, button').length")
        reached = set()
        for _ in range(expected + 20):
            for kind in ("keyDown", "keyUp"):
                self.browser.call("Input.dispatchKeyEvent", type=kind, key="Tab", code="Tab", windowsVirtualKeyCode=9)
            reached.add(self.browser.evaluate("""document.activeElement.matches('.plot, button')
                ? [...document.querySelectorAll('.plot, button')].indexOf(document.activeElement) : -1"""))
        self.assertEqual(len(reached - {-1}), expected)

    def test_the_mouse_zooms_and_a_double_click_shows_all(self):
        self.open(self.compared)
        whole = self.frame_range()
        box = self.browser.evaluate("""(() => { const plot = document.querySelectorAll(".plot")[1];
            plot.scrollIntoView({block: "center"});
            const box = plot.getBoundingClientRect();
            return [box.left + 0.4 * box.width, box.left + 0.6 * box.width, box.top + box.height / 2]; })()""")

        def mouse(kind, x, **more):
            self.browser.call("Input.dispatchMouseEvent", type=kind, x=x, y=box[2], button="left", **more)

        mouse("mousePressed", box[0], clickCount=1)
        mouse("mouseMoved", (box[0] + box[1]) / 2, buttons=1)
        mouse("mouseMoved", box[1], buttons=1)
        mouse("mouseReleased", box[1], clickCount=1)
        low, high = self.frame_range()
        self.assertLess(high - low, 0.4 * (whole[1] - whole[0]))
        for shown in self.shown_ranges():
            self.assertEqual(shown, [low, high])
        for clicks in (1, 2):
            mouse("mousePressed", box[0], clickCount=clicks)
            mouse("mouseReleased", box[0], clickCount=clicks)
        self.assertEqual(self.frame_range(), whole)

    def test_two_fingers_zoom_and_one_leaves_the_page_its_scrolling(self):
        self.open(self.compared, 360)
        whole = self.frame_range()
        box = self.browser.evaluate("""(() => { const plot = document.querySelectorAll(".plot")[1];
            plot.scrollIntoView({block: "center"});
            const box = plot.getBoundingClientRect();
            return [box.left + box.width / 2, box.top + box.height / 2]; })()""")

        def touch(kind, *offsets):
            self.browser.call("Input.dispatchTouchEvent", type=kind, touchPoints=[
                {"x": box[0] + offset, "y": box[1], "id": number} for number, offset in enumerate(offsets)])

        touch("touchStart", -20, 20)
        touch("touchMove", -30, 30)
        touch("touchMove", -60, 60)
        touch("touchEnd")
        low, high = self.frame_range()
        self.assertAlmostEqual((high - low) / (whole[1] - whole[0]), 1 / 3, delta=0.02)
        self.assertEqual(self.browser.evaluate("getComputedStyle(document.querySelector('.plot')).touchAction"), "pan-y")

    def test_everything_has_a_name(self):
        self.open(self.estimated)
        nodes = self.browser.call("Accessibility.getFullAXTree")["nodes"]
        counts = {}
        for node in nodes:
            role = node.get("role", {}).get("value")
            if node.get("ignored") or role not in ("button", "image", "application", "table", "toolbar", "region"):
                continue
            counts[role] = counts.get(role, 0) + 1
            self.assertTrue(node.get("name", {}).get("value", "").strip(), f"{role} without a name")
        for role in ("button", "image", "application", "table"):
            self.assertGreater(counts.get(role, 0), 0, role)
        self.assertEqual(self.browser.evaluate("document.documentElement.lang"), "en")

    def test_prints_light_and_with_its_plots(self):
        self.open(self.compared, scheme="dark")
        self.browser.evaluate("dispatchEvent(new Event('beforeprint'))")
        self.assert_drawn()
        self.assertEqual(self.browser.evaluate("document.querySelectorAll('.plot canvas').length"), 0,
                         "canvases drawn this late come out empty")
        self.assertEqual(self.browser.evaluate("getComputedStyle(document.body).backgroundColor"), "rgb(255, 255, 255)")
        self.assertLessEqual(self.browser.evaluate("Math.max(...[...document.querySelectorAll('body *')].filter((e) => "
                                                   "!e.closest('.scroll *')).map((e) => e.getBoundingClientRect().width))"), 680)
        self.assertEqual(self.browser.evaluate(OVERLAPPING), [])
        self.browser.evaluate("dispatchEvent(new Event('afterprint'))")
        self.assert_drawn()
        path = os.path.join(os.environ.get("PICTURES", self.temporary.name), "printed.pdf")
        self.browser.pdf(path)
        with open(path, "rb") as file:
            pages = len(re.findall(rb"/Type\s*/Page\b", file.read()))
        self.assertIn(pages, range(2, 9))

    def test_ten_thousand_frames_of_one_part_are_all_there(self):
        with tempfile.TemporaryDirectory() as folder:
            poses, truth = write_recording(folder, 10000)
            page = os.path.join(folder, "long.html")
            run("evaluate", truth, poses, "--report", page)
            milliseconds = self.open(page)
            print(f"10,000 frames: {os.path.getsize(page) / 1e6:.2f} MB, all plots drawn after {milliseconds:.0f} ms")
            self.assertLess(os.path.getsize(page), 5_000_000)
            self.assertEqual(self.browser.evaluate("data.frame.length"), 10000)
            self.assert_quiet(page)
            self.assert_drawn()
            self.picture("long")
            # What is drawn of a whole run is thinned out to the screen; a frame's neighbourhood is drawn as it is.
            self.browser.evaluate("frames.show(5000, 5010)")
            self.shown_ranges()
            self.assertEqual(self.browser.evaluate("frames.plots[1].drawn.filter((row) => row >= 5000 && row <= 5010)"),
                             list(range(5000, 5011)))

    def test_several_parts_no_truth_and_no_rows(self):
        with tempfile.TemporaryDirectory() as folder:
            poses, truth = write_recording(folder, 60, ("base", "forearm", "a rather long name of a part & <more>"))
            page = os.path.join(folder, "parts.html")
            run("evaluate", truth, poses, "--report", page)
            for width in (360, 1280):
                self.open(page, width)
                self.picture(f"parts-{width}")
                self.assert_quiet(page)
                self.assert_drawn()
                self.assertEqual(self.browser.evaluate(OVERFLOWING), [])
                self.assertEqual(self.browser.evaluate(OVERLAPPING), [])
            self.assertEqual(self.browser.evaluate("[...document.querySelectorAll('h2')].map((h) => h.textContent)[3]"),
                             "a rather long name of a part & <more>")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]], verbosity=2)
