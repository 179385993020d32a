"""What the pages of the documentation hold: fenced blocks, links, and the headings that links may name."""

import pathlib
import re
from dataclasses import dataclass

ROOT = pathlib.Path(__file__).resolve().parents[2]
FENCE = re.compile(r"^```([a-z]*)\n(.*?)^```$", re.M | re.S)
SHELL = ("", "sh")  # a block that is none says what it is


@dataclass(frozen=True)
class Block:
    line: int
    language: str
    text: str


@dataclass(frozen=True)
class Command:
    line: int
    text: str


def pages():
    """README.md and all of docs/."""
    return [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def blocks(page):
    text = page.read_text(encoding="utf-8")
    return [Block(text.count("\n", 0, match.start()) + 2, match[1], match[2]) for match in FENCE.finditer(text)]


def commands(page):
    """The commands of a page: lines that are no comment and not what a program says (`cylpose: ...`). A backslash joins
    lines."""
    found = []
    for block in blocks(page):
        if block.language not in SHELL:
            continue
        lines = block.text.splitlines()
        number = 0
        while number < len(lines):
            first = number
            command = lines[number]
            while command.endswith("\\") and number + 1 < len(lines):
                number += 1
                command = command[:-1] + lines[number]
            number += 1
            command = re.sub(r"(^|\s)#.*", "", command).strip()
            if command and not re.match(r"\w+: ", command):
                found.append(Command(block.line + first, command))
    return found


def inline_code(page):
    return re.findall(r"`([^`\n]+)`", FENCE.sub("", page.read_text(encoding="utf-8")))


def prose(page):
    """The page without what is code."""
    return re.sub(r"`[^`]*`", "", FENCE.sub("", page.read_text(encoding="utf-8")))


def anchors(page):
    """The anchors that GitHub gives the headings of a page."""
    headings = re.findall(r"^#+ +(.*)$", FENCE.sub("", page.read_text(encoding="utf-8")), re.M)
    plain = [re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading) for heading in headings]
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in plain}
