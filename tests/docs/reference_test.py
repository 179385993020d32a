"""Manual pages and bash completion, as the build makes them.

reference_test.py COMMAND SHARE_DIR MANDOC [UNITTEST OPTION...]
"""

import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

from pages import ROOT

COMMAND, SHARE, MANDOC = sys.argv[1:4]
MANUAL = pathlib.Path(SHARE) / "man" / "man1"
COMPLETION = pathlib.Path(SHARE) / "bash-completion" / "completions" / "cylpose"


def run(*words, **options):
    return subprocess.run(words, check=True, capture_output=True, text=True, timeout=60, **options).stdout


def help_of(*command):
    return run(COMMAND, *command, "--help")


def subcommands():
    return re.findall(r"^  (\w+)", help_of().split("Subcommands:\n")[1].split("\n\n")[0], re.M)


def options_in(text):
    """The long options that a help text or a rendered manual page describes."""
    return set(re.findall(r"^ +(?:-\w, ?)?(--[\w-]+)", text, re.M))


class Help(unittest.TestCase):
    def test_exit_codes_are_those_of_the_page_on_files(self):
        page = (ROOT / "docs" / "files.md").read_text(encoding="utf-8")
        codes = re.findall(r"^ +(\d+)  (.*)$", help_of("estimate").split("Exit codes:\n")[1], re.M)
        self.assertEqual(len(codes), len(re.findall(r"^\| \d+ \|", page.split("## Exit codes")[1], re.M)))
        for code, meaning in codes:
            self.assertIn(f"| {code} | {meaning}", page)

    def test_lines_fit_a_terminal_of_100_columns(self):
        for command in subcommands():
            text = help_of(command)
            for line in text.split("Examples:")[0].splitlines():
                self.assertLessEqual(len(line), 100, command)


class ManualPages(unittest.TestCase):
    def test_there_is_one_for_each_command(self):
        wanted = {"cylpose.1"} | {f"cylpose-{command}.1" for command in subcommands()}
        self.assertEqual({page.name for page in MANUAL.iterdir()}, wanted)

    def test_mandoc_has_nothing_to_say(self):
        for page in MANUAL.iterdir():
            # A date would make every build another one.
            said = subprocess.run([MANDOC, "-T", "lint", "-W", "warning", page], capture_output=True, text=True).stdout
            self.assertEqual([line for line in said.splitlines() if "missing date" not in line], [], page.name)

    def test_they_describe_every_option_and_example_of_the_help(self):
        for command in subcommands():
            with self.subTest(command=command):
                page = run(MANDOC, "-T", "ascii", "-O", "width=200", MANUAL / f"cylpose-{command}.1")
                page = re.sub(r".\x08", "", page)  # bold and underlined
                text = help_of(command)
                self.assertEqual(options_in(page), options_in(text))
                for example in text.split("Examples:\n")[1].split("\n\n")[0].splitlines():
                    self.assertIn(example.strip(), page)


class BashCompletion(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        folder = pathlib.Path(self.folder.name)
        (folder / "camera.yaml").touch()
        (folder / "holiday pictures").mkdir()

    def complete(self, *words):
        """What bash offers for the last of `words`."""
        script = f"source {COMPLETION}\nCOMP_WORDS=(\"$@\")\nCOMP_CWORD=$(($# - 1))\n_cylpose 2>/dev/null\n" \
                 "printf '%s\\n' \"${COMPREPLY[@]}\""
        return [line for line in run("bash", "-c", script, "bash", *words, cwd=self.folder.name).split("\n") if line]

    def test_commands(self):
        self.assertEqual(set(self.complete("cylpose", "")), {*subcommands(), "-h", "--help", "--version"})
        self.assertEqual(self.complete("cylpose", "est"), ["estimate"])

    def test_options(self):
        for command in subcommands():
            offered = {word for word in self.complete("cylpose", command, "--")}
            self.assertEqual(offered, options_in(help_of(command)), command)

    def test_choices(self):
        self.assertEqual(self.complete("cylpose", "estimate", "--format", ""), ["csv", "jsonl", "tum"])
        self.assertEqual(self.complete("cylpose", "estimate", "--method", "t"), ["thesis"])
        self.assertEqual(self.complete("cylpose", "estimate", "--format", "=", "j"), ["jsonl"])
        self.assertEqual(self.complete("cylpose", "estimate", "--format", "="), ["csv", "jsonl", "tum"])
        scenarios = {line.split()[0] for line in run(COMMAND, "synth", "--list").splitlines()}
        self.assertEqual(set(self.complete("cylpose", "synth", "")), scenarios)

    def test_files_and_folders(self):
        self.assertEqual(self.complete("cylpose", "estimate", "--camera", "cam"), ["camera.yaml"])
        self.assertEqual(self.complete("cylpose", "estimate", "hol"), ["holiday pictures"])
        self.assertEqual(self.complete("cylpose", "synth", "--output", ""), ["holiday pictures"])

    def test_values_that_nobody_can_guess(self):
        self.assertEqual(self.complete("cylpose", "estimate", "--fps", ""), [])
        self.assertEqual(self.complete("cylpose", "tune", "--radius-m", ""), [])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
