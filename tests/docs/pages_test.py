"""Links of the documentation lead somewhere, the index names every page, and drawings are well-formed."""

import re
import unittest
import xml.etree.ElementTree

from pages import ROOT, anchors, pages, prose

LINK = re.compile(r"\]\(([^)\s]+)\)")
ELSEWHERE = re.compile(r"[a-z]+:")


class Links(unittest.TestCase):
    def test_relative_links_lead_to_files_and_headings(self):
        checked = 0
        for page in [*pages(), ROOT / "CHANGELOG.md"]:
            for link in LINK.findall(prose(page)):
                if ELSEWHERE.match(link):
                    continue
                checked += 1
                path, _, anchor = link.partition("#")
                target = (page.parent / path).resolve() if path else page
                with self.subTest(page=page.name, link=link):
                    self.assertTrue(target.exists())
                    self.assertTrue(target.is_relative_to(ROOT))
                    if anchor:
                        self.assertIn(anchor, anchors(target))
        self.assertGreater(checked, 50)

    def test_the_index_names_every_page(self):
        index = ROOT / "docs" / "README.md"
        named = {link.partition("#")[0] for link in LINK.findall(index.read_text(encoding="utf-8"))}
        for page in pages():
            if page.parent.name == "docs" and page != index:
                self.assertIn(page.name, named)


class Drawings(unittest.TestCase):
    def test_they_are_well_formed_and_have_a_title(self):
        drawings = list((ROOT / "docs").glob("*.svg"))
        self.assertTrue(drawings)
        for drawing in drawings:
            with self.subTest(drawing=drawing.name):
                root = xml.etree.ElementTree.parse(drawing).getroot()
                self.assertIsNotNone(root.find("{http://www.w3.org/2000/svg}title"))


class QuickStart(unittest.TestCase):
    def test_the_reasons_it_explains_are_those_of_the_library(self):
        sources = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "host" / "src").glob("*.cpp"))
        text = (ROOT / "docs" / "quickstart.md").read_text(encoding="utf-8")
        table = text.split("## If there is no pose")[1]
        reasons = [reason for row in re.findall(r"^\| (`[^|]*) \|", table, re.M) for reason in re.findall(r"`([^`]+)`", row)]
        self.assertGreater(len(reasons), 5)
        for reason in reasons:
            self.assertIn(reason, sources)


if __name__ == "__main__":
    unittest.main()
