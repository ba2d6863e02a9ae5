# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""tools/score_changes.py sums and compares as one does by hand, and asks the program for each home once."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

TOOL = pathlib.Path(__file__).resolve().parents[2] / "tools" / "score_changes.py"
# Home 1 has two changes of which one is found; home 2 has one, which is not, and a wrong claim. A static home has a ghost share of 1 %.
FAKE = """#!{python}
import json, pathlib, sys
command, rest = sys.argv[1], sys.argv[2:]
value = lambda name: rest[rest.index(name) + 1]
with open("{log}", "a") as log: log.write(command + "\\n")
if command == "simulate":
    home = pathlib.Path(value("-o")); home.mkdir()
    (home / "seed").write_text(value("--seed"))
    if value("--dynamics") != "static": (home / "dynamics.json").write_text("1")
if command == "run":
    run = pathlib.Path(value("-o")); run.mkdir()
    objects = [{{"state": "gone", "appeared": False, "moved_from": None}}, {{"state": "present", "appeared": False, "moved_from": None}}]
    (run / "objects.json").write_text(json.dumps({{"objects": objects}}))
if command == "eval":
    seed = int((pathlib.Path(value("--gt")) / "seed").read_text())
    one = {{"truths": 2, "found": 1, "claims": 1}} if seed == 1 else {{"truths": 1, "found": 0, "claims": 1}}
    pixels = {{"true_positives": 6 * seed, "false_positives": 2, "false_negatives": seed}}
    scores = {{"surface": {{"at": [{{"precision": 0.99, "recall": 0.98}}]}}}}
    if "--changes" in rest:
        scores["changes"] = {{"gone": one, "new": one, "moved": one, "ghost_share": 0.03, "completeness": 0.97, "moving_pixels": pixels}}
    pathlib.Path(value("--json")).write_text(json.dumps(scores))
"""


class ScoreChanges(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        self.program = self.root / "panoptic"
        self.program.write_text(FAKE.format(python=sys.executable, log=self.root / "log"))
        os.chmod(self.program, 0o755)

    def table(self, *arguments):
        command = [sys.executable, TOOL, self.program, self.root / "work", *arguments]
        result = subprocess.run(command, capture_output=True, text=True, check=False)
        self.assertEqual(result.returncode, 0, result.stderr)
        return [[cell.strip() for cell in line.strip("|").split("|")] for line in result.stdout.splitlines() if line.startswith("| with")]

    def test_sums_over_homes_and_compares_with_static_ones(self):
        changes, static = self.table("--seeds", "1", "2", "--dynamics", "changes", "static", "--variants", "with")
        self.assertEqual(changes, ["with", *["40.0"] * 3, *["1 of 3, 1 wrong"] * 3, "81.8", "85.7", "3.00", "2.00", "97.00", "-1.00"])
        self.assertEqual(static[4:7], ["0 of 0, 2 wrong", "0 of 0, 0 wrong", "0 of 0, 0 wrong"])
        self.assertEqual(static[9:], ["1.00", "0.00", "98.00", "0.00"])

    def test_scores_are_kept_and_homes_are_not(self):
        arguments = ["--seeds", "1", "--dynamics", "changes", "--variants", "with", "off"]
        self.table(*arguments)
        self.assertEqual((self.root / "log").read_text().split(), ["simulate", "run", "eval", "run", "eval"])
        self.table(*arguments)
        self.assertEqual(len((self.root / "log").read_text().split()), 5)
        self.assertTrue(all(path.suffix == ".json" for path in (self.root / "work").iterdir()))

    def test_a_program_that_is_not_there_is_named(self):
        result = subprocess.run([sys.executable, TOOL, self.root / "none", self.root / "work", "--seeds", "1"], capture_output=True,
                                text=True, check=False)
        self.assertEqual(result.returncode, 2)
        self.assertIn("none; build it first", result.stderr)


if __name__ == "__main__":
    unittest.main()
