"""The example script and the pages' snippets, as a user runs them."""

import pathlib
import re
import shutil
import subprocess
import sys
import unittest

import numpy as np

import scene

ROOT = pathlib.Path(__file__).parents[2]
SCRIPT = ROOT / "examples/notebook/pose_plot.py"


class PosePlot(unittest.TestCase):
    def test_prints_the_table_and_draws_overlay_and_depth(self):
        frames = scene.sequence()
        folder = scene.folder() / "plot"
        folder.mkdir()
        ended = subprocess.run([sys.executable, SCRIPT, frames.camera, frames.parts, frames.video], cwd=folder,
                               capture_output=True, text=True)
        self.assertEqual((ended.returncode, ended.stderr), (0, ""))
        self.assertRegex(ended.stdout, r"^6 frames, 6 with \w+ measured\n +0.00 s  ok +z 1\.[45]\d+ m, sigma \d\.\d+ mm\n")
        self.assertEqual(len(ended.stdout.splitlines()), 7)
        overlay = np.asarray(scene.Image.open(folder / "overlay.png"))
        # Yellow is the predicted cylinder's outline.
        self.assertGreater(np.count_nonzero((overlay == (255, 255, 0)).all(axis=-1)), 100)
        depth = np.asarray(scene.Image.open(folder / "depth.png"))
        self.assertGreater(np.count_nonzero((depth == (0, 0, 128)).all(axis=-1)), 300)  # navy is the curve


class Snippets(unittest.TestCase):
    def test_of_the_pages_run(self):
        frames = scene.sequence()
        folder = scene.folder() / "snippets"
        folder.mkdir()
        for file, name in ((frames.camera, "camera.yaml"), (frames.parts, "parts.yaml"), (frames.video, "video.mp4"),
                           (frames.files[0], "photo.png")):
            shutil.copy(file, folder / name)
        given = ("import cylpose, numpy\nfrom PIL import Image\n"
                 "image = numpy.ascontiguousarray(numpy.asarray(Image.open('photo.png'))[..., ::-1])\n")
        for page in ("README.md", "docs/python.md"):
            snippets = re.findall(r"^```python\n(.*?)^```$", (ROOT / page).read_text(encoding="utf-8"), re.M | re.S)
            self.assertEqual(len(snippets), 1)
            ended = subprocess.run([sys.executable, "-c", given + snippets[0]], cwd=folder, capture_output=True, text=True)
            self.assertEqual((ended.returncode, ended.stderr), (0, ""), page)
            self.assertGreaterEqual(len(ended.stdout.splitlines()), 6, page)


if __name__ == "__main__":
    unittest.main()
