"""Every command of the documentation and of the help texts, run as a reader would, with rendered images for theirs.

commands_test.py COMMAND BUILD_DIR NATS_SERVER [UNITTEST OPTION...]

Each page has a folder of its own, holding what its commands name. Servers and workers are left running until the page
ends. What cannot run in a test is listed in NOT_RUN; everything else that fails, fails the test.
"""

import csv
import json
import math
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.request

from pages import ROOT, Command, commands, inline_code, pages

COMMAND, BUILD, NATS_SERVER = (pathlib.Path(argument) for argument in sys.argv[1:4])
PATIENCE_S = 120

# Why a command is not run. Those of scripts/ must exist all the same, and know the words they are given.
NOT_RUN = [
    (r"scripts/(build|demo|setup|test|test-tsan|bench)\b", "builds, tests or measures for minutes"),
    (r"git clone ", "needs the network"),
    (r"(sudo|apt-get|systemctl|journalctl) ", "changes this machine"),
    (r".*/dev/video", "needs a camera"),
]

# What stands for the reader's own.
STAND_INS = [
    (r"\bHOST\b", "127.0.0.1"),
    (r"\bestimate \.\.\.", "estimate --camera camera.yaml --parts parts.yaml --output shortened.csv frames/"),
    (r"--server \.\.\.", "--server nats://127.0.0.1:4222"),
    (r"^cylpose (worker|nodes|submit|collect)(?!.* --server)", r"cylpose \1 --server nats://127.0.0.1:4222"),
    (r" \.\.\.$", " --camera camera.yaml --parts parts.yaml --output shortened.csv frames/"),
]

OPTION = re.compile(r"(?<![\w-])--[a-z][\w-]*")
FOREIGN = ("cmake ", "ctest ", "sudo ", "ssh ")  # inline code with options of other programs

SERVER = re.compile(r"nats-server\b")
WORKER = re.compile(r"cylpose worker\b")


def not_run(command):
    return any(re.match(pattern, command) for pattern, _ in NOT_RUN)


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def cylpose(*arguments, cwd):
    subprocess.run([COMMAND, *arguments], cwd=cwd, check=True, timeout=PATIENCE_S, capture_output=True)


def render_inputs(folder):
    """Everything that pages name, in `folder`."""
    cylpose("synth", "series3", "--frames", "6", "--video", "--output", "frames", cwd=folder)
    frames = folder / "frames"
    for name in ("camera.yaml", "parts.yaml", "truth.csv", "frame_0000.png"):
        shutil.copy(frames / name, folder)
    shutil.copy(frames / "frame_0000.png", folder / "photo.png")
    for video in frames.glob("video.*"):
        video.rename(folder / "video.mp4")
    cylpose("estimate", "--camera", "camera.yaml", "--parts", "parts.yaml", "--output", "poses.csv", "frames/",
            cwd=folder)
    (folder / "extrinsics.yaml").write_text("rotation: [-0.5, 0.5, -0.5, 0.5]\ntranslation_m: [0.3, 0, 0.1]\n")
    for name in ("scripts", "cluster", "examples"):
        (folder / name).symlink_to(ROOT / name)


class Reader:
    """Runs the commands of one page in one folder, as one session: variables and the folder last."""

    def __init__(self, inputs, bin_folder):
        self.home = pathlib.Path(tempfile.mkdtemp())
        self.folder = self.home / "here"
        shutil.copytree(inputs, self.folder, symlinks=True)
        self.port = free_port()
        self.monitor_port = free_port()
        self.background = []
        self.session = self.home / "session"
        self.session.write_text(f"cd {self.folder}\n")
        self.environment = dict(os.environ, PATH=f"{bin_folder}:{os.environ['PATH']}", HOME=str(self.home))

    def close(self):
        self.stop_background()
        shutil.rmtree(self.home)

    def stop_background(self):
        for process in reversed(self.background):
            process.send_signal(signal.SIGTERM)
        for process in reversed(self.background):
            try:
                process.wait(timeout=10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self.background = []

    def stand_in(self, command):
        for pattern, replacement in STAND_INS:
            command = re.sub(pattern, replacement, command)
        return command.replace(":4222", f":{self.port}")

    def run(self, command):
        """None, or what went wrong."""
        command = self.stand_in(command)
        if SERVER.match(command):
            self.stop_background()  # another server, another set-up
            ours = f"-a 127.0.0.1 -p {self.port} -m {self.monitor_port} -sd {self.home}/js"
            return self.start(f"{command} {ours}", lambda: self.connections() is not None)
        if WORKER.match(command):
            before = self.connections() or 0
            return self.start(command, lambda: (self.connections() or 0) > before)
        script = f"set -euo pipefail\n. {self.session}\n{command}\n{{ export -p; echo cd $PWD; }} >{self.session}\n"
        try:
            done = subprocess.run(["bash", "-c", script], env=self.environment, timeout=PATIENCE_S,
                                  stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace")
        except subprocess.TimeoutExpired:
            return f"still running after {PATIENCE_S} s"
        return None if done.returncode == 0 else f"exit code {done.returncode}\n{done.stdout}{done.stderr}"

    def start(self, command, is_ready):
        log = self.home / f"log{len(self.background)}"
        with open(log, "wb") as output:
            process = subprocess.Popen(["bash", "-c", f". {self.session}\nexec {command}"], env=self.environment,
                                       stdin=subprocess.DEVNULL, stdout=output, stderr=output)
        self.background.append(process)
        deadline = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline:
            if process.poll() is not None:
                return f"ended with {process.returncode}\n{log.read_text(errors='replace')}"
            if is_ready():
                return None
            time.sleep(0.02)
        return f"not ready after {PATIENCE_S} s\n{log.read_text(errors='replace')}"

    def connections(self):
        """How many clients the server has; None where none answers."""
        try:
            with urllib.request.urlopen(f"http://127.0.0.1:{self.monitor_port}/connz", timeout=10) as answer:
                return json.load(answer)["num_connections"]
        except OSError:
            return None


def words_unknown_to(script, words):
    """Those that the text of a script, and of the programs it starts, does not have."""
    texts = [path.read_text(errors="replace") for path in
             [ROOT / script, ROOT / "scripts" / "bench_cluster", *sorted((ROOT / "bench").rglob("*main.cpp"))]]
    return [word for word in words if not any(word in text for text in texts)]


class Documentation(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp())
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.inputs = cls.folder / "inputs"
        cls.inputs.mkdir()
        render_inputs(cls.inputs)
        (cls.inputs / "build").mkdir()
        (cls.inputs / "build" / "release").symlink_to(BUILD)
        cls.bin = cls.folder / "bin"
        cls.bin.mkdir()
        (cls.bin / "cylpose").symlink_to(COMMAND)
        (cls.bin / "nats-server").symlink_to(NATS_SERVER)

    def run_all(self, name, found):
        """The reader, who has run them all."""
        reader = Reader(self.inputs, self.bin)
        self.addCleanup(reader.close)
        for command in found:
            with self.subTest(page=name, line=command.line):
                if not_run(command.text):
                    self.check_script(command.text)
                    continue
                failure = reader.run(command.text)
                self.assertIsNone(failure, f"{name}:{command.line}: {command.text}\n{failure}")
        return reader

    def check_script(self, command):
        script, *words = command.split()
        if not script.startswith("scripts/"):
            return
        self.assertTrue(os.access(ROOT / script, os.X_OK), command)
        self.assertEqual(words_unknown_to(script, [word for word in words if word.startswith("--")]), [], command)

    def test_every_exception_is_needed(self):
        found = [command for page in pages() for command in commands(page)] + help_examples()
        for pattern, why in NOT_RUN:
            self.assertTrue(any(re.match(pattern, command.text) for command in found), f"{pattern}: {why}")

    def test_the_quick_start_ends_with_the_right_poses(self):
        reader = self.run_all("quickstart.md", commands(ROOT / "docs" / "quickstart.md"))
        with open(self.inputs / "truth.csv", newline="", encoding="utf-8") as file:
            truth = {row["frame"]: row for row in csv.DictReader(file)}
        for name, frames, limit_m in (("poses.csv", 1, 0.002), ("video.csv", len(truth), 0.03)):
            with open(reader.folder / name, newline="", encoding="utf-8") as file:
                rows = list(csv.DictReader(file))
            self.assertEqual(len(rows), frames, name)
            for row in rows:
                self.assertEqual((row["part"], row["status"]), ("link", "ok"), name)
                error = math.dist([float(row[c]) for c in ("cx", "cy", "cz")],
                                  [float(truth[row["frame"]][c]) for c in ("cx", "cy", "cz")])
                self.assertLess(error, limit_m, f"{name}, frame {row['frame']}")

    def test_options_that_the_text_names_exist(self):
        known = set(OPTION.findall(help_of() + "".join(help_of(subcommand) for subcommand in subcommands())))
        for script in (ROOT / "scripts").iterdir():
            known |= set(OPTION.findall(script.read_text(encoding="utf-8")))
        named = 0
        for page in pages():
            for code in inline_code(page):
                if code.startswith(FOREIGN):
                    continue
                for option in OPTION.findall(code):
                    named += 1
                    self.assertIn(option, known, f"{page.name}: {code}")
        self.assertGreater(named, 50)

    def test_examples_of_the_help(self):
        """In the order of the subcommands: what is submitted there is there to be collected."""
        for subcommand in subcommands():
            self.assertTrue(examples_of(subcommand), f"cylpose {subcommand} --help has no example")
        self.run_all("--help", [Command(0, "nats-server -js"), *help_examples()])


def help_of(*command):
    return subprocess.run([COMMAND, *command, "--help"], check=True, capture_output=True, text=True).stdout


def subcommands():
    return re.findall(r"^  (\w+)", help_of().split("Subcommands:\n")[1].split("\n\n")[0], re.M)


def examples_of(subcommand):
    text = help_of(subcommand)
    return re.findall(r"^  (.+)", text.split("Examples:\n")[1].split("\n\n")[0], re.M) if "Examples:\n" in text else []


def help_examples():
    return [Command(number, example) for subcommand in subcommands()
            for number, example in enumerate(examples_of(subcommand), 1)]


def add_page_tests():
    def page_test(page):
        def test(self):
            self.run_all(page.name, commands(page))
        return test

    for page in pages():
        if commands(page) and page.stem != "quickstart":
            setattr(Documentation, f"test_page_{page.stem}", page_test(page))


if __name__ == "__main__":
    add_page_tests()
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
