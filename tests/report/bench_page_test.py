"""The bench's page as a reader sees it: made by the real program from a run made up here, in headless Chromium.

bench_page_test.py REPORT_PROGRAM CHROMIUM TIDY [UNITTEST OPTION...]; with PICTURES=DIR in the environment it leaves
screenshots.
"""

import json
import os
import random
import statistics
import subprocess
import sys
import tempfile
import unittest

from chromium import Chromium
from page_checks import FAINT_TEXTS, OVERFLOWING, OVERLAPPING, complaints, requests, tidied

PROGRAM, CHROMIUM, TIDY = sys.argv[1:4]
WIDTHS = (360, 1280, 1920)
BACKENDS = ("serial", "opencv", "opencl", "cluster")
SIZES = ("640x400", "1280x720", "3840x2160")
STAGES = ("gate", "morphology", "edges", "locate", "lines", "refine <x> & more")

TABLES = """[...document.querySelectorAll("table")].map((table) => [...table.rows].map((row) => [...row.cells].map((c) => c.textContent)))"""

# Per bar: shares of the width [left, width] of its boxes, the stages and what lies between them.
BARS = """[...document.querySelectorAll(".track")].map((track) => {
  const whole = track.getBoundingClientRect();
  return [...track.children].map((e) => {
    const box = e.getBoundingClientRect();
    return [e.className, (box.left - whole.left) / whole.width, box.width / whole.width];
  });
})"""


def made_up_run():
    generator = random.Random(1)
    benchmarks = []

    def add(name, milliseconds, counters):
        for factor in (1, 1.5, 1.1):
            benchmarks.append({"name": name, "run_type": "iteration", "family_index": len(benchmarks),
                               "real_time": milliseconds * factor, "time_unit": "ms", **counters})
    for kind in ("detect", "estimate"):
        for backend in BACKENDS:
            for scene in ("full", "roi"):
                for size in SIZES:
                    if (backend, size) == ("cluster", "3840x2160"):
                        continue
                    time = generator.uniform(0.2, 20)
                    shares = [generator.uniform(0.05, 0.15) for _ in STAGES]
                    add(f"{kind}/{backend}/{scene}/{size}", time, {"frame_bytes": 3e6, **{
                        f"stage_ms/{i:02}/{stage}": time * share
                        for i, (stage, share) in enumerate(zip(STAGES, shares))}})
    for size in SIZES:
        add("read_bandwidth/" + size, 0.01, {"GB/s": 20})
    add("overhead/opencl", 0.07, {})
    return {"context": {"processor": "abacus <b>", "date": "today", "load_avg": [0.5, 0.25]}, "benchmarks": benchmarks}


class BenchPageTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="cylpose_bench_")
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.page = os.path.join(cls.temporary.name, "bench.html")
        run = made_up_run()
        with open(cls.page + ".json", "w", encoding="utf-8") as file:
            json.dump(run, file)
        subprocess.run([PROGRAM, "run", cls.page + ".json", "--table", cls.page + ".txt", "--picture",
                        cls.page + ".png", "--report", cls.page], check=True, capture_output=True)
        repetitions = {}
        cls.counters = {}
        for entry in run["benchmarks"]:
            repetitions.setdefault(entry["name"], []).append(entry["real_time"])
            cls.counters[entry["name"]] = entry
        cls.medians = {name: statistics.median(times) for name, times in repetitions.items()}
        cls.browser = Chromium(CHROMIUM)
        cls.addClassCleanup(cls.browser.__exit__)

    def open(self, width=1280, scheme="light"):
        self.browser.resize(width, mobile=width < 600)
        self.browser.prefer(scheme)
        self.browser.open(self.page)

    def test_reads_at_every_width_in_light_and_dark(self):
        for width in WIDTHS:
            for scheme in ("light", "dark"):
                with self.subTest(width=width, scheme=scheme):
                    self.open(width, scheme)
                    if "PICTURES" in os.environ:
                        os.makedirs(os.environ["PICTURES"], exist_ok=True)
                        self.browser.screenshot(os.path.join(os.environ["PICTURES"], f"bench-{width}-{scheme}.png"))
                    self.assertEqual(complaints(self.browser), [])
                    self.assertEqual(requests(self.browser), ["file://" + self.page])
                    self.assertEqual(self.browser.evaluate("document.documentElement.scrollWidth"), width)
                    self.assertEqual(self.browser.evaluate(OVERFLOWING), [])
                    self.assertEqual(self.browser.evaluate(OVERLAPPING), [])
                    texts = self.browser.evaluate(FAINT_TEXTS)
                    self.assertGreater(texts["looked"], 200)
                    self.assertEqual(texts["faint"], [])

    def test_is_valid_html(self):
        self.assertEqual(tidied(TIDY, self.page), "")

    def test_tables_hold_the_medians_of_the_run(self):
        self.open()
        tables = self.browser.evaluate(TABLES)
        self.assertEqual(len(tables), 5)
        for kind, table in (("detect", tables[0]), ("estimate", tables[2])):
            self.assertEqual(table[0][1:6], [*BACKENDS, "reading"])
            self.assertEqual(len(table), 7)
            for row in table[1:]:
                scene, size = row[0].split(" ")
                for backend, text in zip(BACKENDS, row[1:5]):
                    median = self.medians.get(f"{kind}/{backend}/{scene}/{size}")
                    self.assertEqual(text, "-" if median is None else f"{median:.3f}")
                self.assertEqual(float(row[5]), 0.15)  # 3 MB at 20 GB/s
                yardstick = self.medians[f"{kind}/opencl/{scene}/{size}"]
                self.assertEqual(row[6], f"{self.medians[f'{kind}/serial/{scene}/{size}'] / yardstick:.1f}")
        self.assertEqual(tables[1][0][1:], list(STAGES))
        self.assertEqual(len(tables[1]), 1 + 2 * (4 * 3 - 1))
        self.assertEqual([row[:2] for row in tables[4][1:]],
                         [*([f"read_bandwidth/{size}", "0.0110"] for size in SIZES), ["overhead/opencl", "0.0770"]])

    def test_json_holds_the_numbers_of_the_run(self):
        self.open()
        data = self.browser.evaluate("JSON.parse(document.getElementById('data').textContent)")
        self.assertEqual({b["name"]: b["median_ms"] for b in data["benchmarks"]}, self.medians)
        self.assertEqual(data["context"]["processor"], "abacus <b>")
        stage = "stage_ms/05/" + STAGES[-1]
        for benchmark in data["benchmarks"]:
            if stage in benchmark["counters"]:
                self.assertEqual(benchmark["counters"][stage], self.counters[benchmark["name"]][stage])

    def test_bars_have_the_lengths_of_the_numbers(self):
        self.open()
        bars = iter(self.browser.evaluate(BARS))
        for kind in ("detect", "estimate"):
            for scene in ("full", "roi"):
                for size in SIZES:
                    names = [n for n in (f"{kind}/{b}/{scene}/{size}" for b in BACKENDS) if n in self.medians]
                    longest = max(self.medians[name] for name in names)
                    for name in names:
                        between, *stages, limit = next(bars)
                        self.assertEqual(between[0], "between")
                        self.assertAlmostEqual(between[2], self.medians[name] / longest, delta=0.01)
                        self.assertEqual(len(stages), len(STAGES))
                        end = 0
                        for i, (stage, (_, left, width)) in enumerate(zip(STAGES, stages)):
                            self.assertAlmostEqual(left, end, delta=0.01)
                            expected = self.counters[name][f"stage_ms/{i:02}/{stage}"] / longest
                            self.assertAlmostEqual(width, expected, delta=0.01)
                            end += expected
                        self.assertEqual(limit[0], "limit")
                        self.assertAlmostEqual(limit[1], 0.15 / longest, delta=0.01)
        self.assertIsNone(next(bars, None))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]], verbosity=2)
