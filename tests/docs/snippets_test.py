"""Every C++ snippet of the documentation compiles, inside a function that has what the text takes for granted.

snippets_test.py BUILD_DIR [UNITTEST OPTION...]
"""

import json
import pathlib
import shlex
import subprocess
import sys
import tempfile
import unittest

from pages import ROOT, blocks, pages

BUILD = pathlib.Path(sys.argv[1])
LIKE = "apps/estimate_run.cpp"  # sees every public header; snippets are compiled with its flags

# For each page, what stands before the function and what the function is given.
SURROUNDINGS = {
    "README.md": ("#include <cylpose/estimator.hpp>\n#include <cylpose/image_cv.hpp>\n#include <opencv2/core.hpp>\n",
                  "const cv::Mat& image"),
    "embedding.md": ("#include <cylpose/default_backend.hpp>\n#include <cylpose/graph/pipeline.hpp>\n"
                     "void use(const cylpose::FrameEstimate& estimate);\n",
                     "const cylpose::CameraModel& camera, const std::vector<cylpose::PartModel>& parts, std::int64_t id, "
                     "double timestamp_s, cylpose::ImageView image, std::shared_ptr<const void> owner"),
}


def compiler_of_our_sources():
    """Compiler and flags, without input and output."""
    entries = json.loads((BUILD / "compile_commands.json").read_text(encoding="utf-8"))
    words = shlex.split(next(entry["command"] for entry in entries if entry["file"] == str(ROOT / LIKE)))
    return [word for word in words[:words.index("-o")] if not word.startswith(("-W", "-O"))]


class Snippets(unittest.TestCase):
    def test_they_compile(self):
        compiler = compiler_of_our_sources()
        compiled = 0
        for page in pages():
            for block in blocks(page):
                if block.language != "cpp":
                    continue
                with self.subTest(page=page.name, line=block.line), tempfile.TemporaryDirectory() as folder:
                    before, given = SURROUNDINGS[page.name]
                    source = pathlib.Path(folder) / "snippet.cpp"
                    source.write_text(f"{before}void snippet({given}) {{\n#line {block.line} \"{page.name}\"\n{block.text}}}\n")
                    done = subprocess.run([*compiler, "-fsyntax-only", source], capture_output=True, text=True)
                    self.assertEqual(done.returncode, 0, done.stderr)
                    compiled += 1
        self.assertGreaterEqual(compiled, len(SURROUNDINGS))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
