"""The example script, as a user runs it."""

import pathlib
import subprocess
import sys
import unittest

import numpy as np

import scene

SCRIPT = pathlib.Path(__file__).parents[2] / "examples/notebook/pose_plot.py"


class PosePlot(unittest.TestCase):
    def test_prints_the_table_and_draws_overlay_and_depth(self):
        frames = scene.sequence()
        folder = scene.folder() / "plot"
        folder.mkdir()
        ended = subprocess.run([sys.executable, SCRIPT, frames.camera, frames.parts, frames.video], cwd=folder,
                               capture_output=True, text=True)
        self.assertEqual((ended.returncode, ended.stderr), (0, ""))
        self.assertRegex(ended.stdout, r"^6 frames, 6 with \w+ measured\n +0.00 s  ok +z 1\.[45]\d+ m, sigma 0\.\d+ mm\n")
        self.assertEqual(len(ended.stdout.splitlines()), 7)
        overlay = np.asarray(scene.Image.open(folder / "overlay.png"))
        # Yellow is the predicted cylinder's outline.
        self.assertGreater(np.count_nonzero((overlay == (255, 255, 0)).all(axis=-1)), 100)
        depth = np.asarray(scene.Image.open(folder / "depth.png"))
        self.assertGreater(np.count_nonzero((depth == (0, 0, 128)).all(axis=-1)), 300)  # navy is the curve


if __name__ == "__main__":
    unittest.main()
