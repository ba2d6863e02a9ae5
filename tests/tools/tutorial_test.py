# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""docs/tutorial.md does what it says: runs its commands in their order, and compares what they print with what it shows.

Usage: tutorial_test.py PROGRAM

A block `sh` is run; a block `text` after it is what it prints. Numbers may differ, lines may not, and `...` stands for any lines.
Which chairs there are must be as shown.
"""
import json
import os
import pathlib
import re
import signal
import struct
import subprocess
import sys
import tempfile
import unittest
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parents[2]
SHARED = pathlib.Path(os.environ.get("PANOPTIC_SHARED", ROOT / "../shared"))
MODELS = pathlib.Path(os.environ.get("PANOPTIC_MODELS", SHARED / "models"))
NEEDS_WEIGHTS = "<!-- needs the weights -->"
LEFT_OUT = "..."


def steps(text):
    """(commands, shown output or None, needs weights) of each block of commands."""
    found = []
    for match in re.finditer(r"(?P<before>[^\n]*)\n```(?P<kind>sh|text)\n(?P<body>.*?)```", text, re.DOTALL):
        if match["kind"] == "sh":
            found.append([match["body"], None, match["before"] == NEEDS_WEIGHTS])
        else:
            found[-1][1] = match["body"]
    return found


def plain(line):
    """A line without what may differ from machine to machine: numbers, and the spaces that align them."""
    return re.sub(r"\s+", " ", re.sub(r"\d+(\.\d+)?", "N", line)).strip()


def differs(shown, printed):
    """The first line that is shown and was not printed in its place; None if all is as shown."""
    rest = [plain(line) for line in printed.splitlines() if line.strip()]
    may_skip = False
    for line in shown.splitlines():
        if line.strip() == LEFT_OUT:
            may_skip = True
            continue
        if may_skip and plain(line) in rest:
            rest = rest[rest.index(plain(line)):]
        if not rest or rest[0] != plain(line):
            return line
        rest = rest[1:]
        may_skip = False
    return None if may_skip or not rest else f"(end; then came: {rest[0]})"


class Comparison(unittest.TestCase):
    def test_numbers_may_differ_and_lines_may_not(self):
        self.assertIsNone(differs("a 1.5 m\nb\n", "a   22 m\n\nb\n"))
        self.assertIsNone(differs("a\n...\nd\n", "a\nb\nc\nd\n"))
        self.assertIsNone(differs("a\n  ...\n", "a\nb\n"))
        self.assertEqual(differs("a\nb\n", "a\nc\n"), "b")
        self.assertEqual(differs("a\n...\nd\n", "a\nb\n"), "d")
        self.assertEqual(differs("chair 1\nchair 2\n", "chair 1\n"), "chair 2")
        self.assertIn("chair", differs("chair 1\n", "chair 1\nchair 2\n"))


class Unpacking(unittest.TestCase):
    def refusal(self, content, before=()):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "a.sens"
            path.write_bytes(content)
            for name in before:
                (path.parent / name).mkdir(parents=True)
            result = subprocess.run([ROOT / "tools/unpack_sens", path, path.parent / "out"], capture_output=True, text=True)
            self.assertNotEqual(result.returncode, 0)
            self.assertEqual(len(result.stderr.splitlines()), 1)
            return result.stderr

    def test_refuses_what_it_cannot_unpack_in_one_line(self):
        header = struct.pack("<IQ", 4, 0) + bytes(256)
        size = struct.pack("<4I", 640, 480, 640, 480)
        self.assertIn("ends too early", self.refusal(b"short"))
        self.assertIn("version 3", self.refusal(struct.pack("<IQ", 3, 0)))
        self.assertIn("colour compression 0", self.refusal(header + struct.pack("<ii", 0, 1) + size + struct.pack("<fQ", 1000, 0)))
        self.assertIn("5000 units a metre", self.refusal(header + struct.pack("<ii", 2, 1) + size + struct.pack("<fQ", 5000, 0)))
        self.assertIn("already holds something",
                      self.refusal(header + struct.pack("<ii", 2, 1) + size + struct.pack("<fQ", 1000, 0), ["out/photos"]))


class Tutorial(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        (self.root / "build/release").mkdir(parents=True)
        (self.root / "build/release/panoptic").symlink_to(PROGRAM)
        for name in ("tools", "configs"):
            (self.root / name).symlink_to(ROOT / name)
        self.environment = {**os.environ, "PANOPTIC_MODELS": str(MODELS)}

    def run_commands(self, commands):
        result = subprocess.run(["bash", "-ec", commands], cwd=self.root, env=self.environment, capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, commands + result.stdout + result.stderr)
        return result.stdout

    def look(self, commands):
        """Starts the viewer, fetches its page, and ends it as a person does."""
        with subprocess.Popen(["bash", "-ec", "exec " + commands], cwd=self.root, env=self.environment, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True) as viewer:
            try:
                address = next((line.split()[-1] for line in viewer.stdout if line.startswith("look at")), None)
                self.assertIsNotNone(address, commands)
                self.assertEqual(urllib.request.urlopen(address + "api/scene", timeout=30).status, 200)
            finally:
                viewer.send_signal(signal.SIGINT)
                viewer.communicate(timeout=60)

    def test_its_commands_do_what_it_shows(self):
        for commands, shown, needs_weights in steps((ROOT / "docs/tutorial.md").read_text(encoding="utf-8")):
            if needs_weights and not MODELS.is_dir():
                print(f"not run, there are no networks in {MODELS}: {commands.splitlines()[0]}")
            elif commands.startswith("export PATH="):
                self.environment["PATH"] = f"{self.root}/build/release:{os.environ['PATH']}"
            elif commands.startswith("panoptic view"):
                self.look(commands)
            else:
                printed = self.run_commands(commands)
                if shown is not None:
                    self.assertIsNone(differs(shown, printed), f"{commands}printed\n{printed}")
        self.check_what_it_leads_to()

    def check_what_it_leads_to(self):
        out = self.root / "out/tutorial"
        for name in ("map/views/top_panoptic.png", "map/scene.glb", "map/mesh.ply", "chair.png"):
            self.assertTrue((out / name).is_file(), name)
        objects = json.loads((out / "map/objects.json").read_text())["objects"]
        self.assertEqual(sum(o["class"] == "chair" for o in objects), 4)
        # The unpacked folder is the same recording as the file, bit for bit.
        hashes = []
        for recording in ("home", "room"):
            self.run_commands(f"panoptic run out/tutorial/{recording} --frames 0:8 --no-pictures -o out/{recording}")
            hashes.append(json.loads((self.root / "out" / recording / "report.json").read_text())["map_hash"])
        self.assertEqual(*hashes)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    PROGRAM = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main()
