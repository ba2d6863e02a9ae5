# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""tools/score_recordings moves recordings, keeps predictions, and sums up as it says.

Usage: test_score_recordings.py [PROGRAM]    with the program and the shared recordings, it maps, too
"""
import importlib.machinery
import importlib.util
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
TOOL = ROOT / "tools/score_recordings"
SHARED = pathlib.Path(os.environ.get("PANOPTIC_SHARED", ROOT / "../shared"))
PROGRAM = sys.argv.pop() if len(sys.argv) == 2 and not sys.argv[1].startswith("-") else None

sys.dont_write_bytecode = True
sys.path.insert(0, str(TOOL.parent))
loader = importlib.machinery.SourceFileLoader("score_recordings", str(TOOL))
tool = importlib.util.module_from_spec(importlib.util.spec_from_loader("score_recordings", loader))
loader.exec_module(tool)
tables = tool.score_tables


def translations(text):
    """Of poses in lines of 4 or of 16 numbers."""
    numbers = [float(word) for word in text.split()]
    return [numbers[i + 3:i + 12:4] for i in range(0, len(numbers), 16)]


class Choices(unittest.TestCase):
    def test_a_comma_divides_settings_only_where_a_key_follows(self):
        variant = tool.parse_variant("a:tracker.iou_threshold=0.1,labels=indoor,preset=paper,b.list=x,y", "enet")
        self.assertEqual(variant.settings, ["tracker.iou_threshold=0.1", "labels=indoor", "b.list=x,y"])
        self.assertEqual((variant.name, variant.preset, variant.networks), ("a", "paper", "enet+yolo"))

    def test_the_names_of_presets_imply_them(self):
        self.assertEqual(tool.parse_variant("paper", "enet").preset, "paper")
        self.assertIsNone(tool.parse_variant("paper:preset=none", "enet").preset)
        self.assertIsNone(tool.parse_variant("mine", "enet").preset)

    def test_the_paper_has_one_network_of_each_kind_unless_others_are_named(self):
        self.assertEqual(tool.parse_variant("paper", "enet+deeplab+yolo").networks, "enet+yolo")
        self.assertEqual(tool.parse_variant("paper:networks=deeplab", "enet+deeplab+yolo").networks, "deeplab")

    def test_only_options_of_mapping_alone_leave_predictions_as_they_are(self):
        variant = tool.parse_variant("a:tracker.iou_threshold=0.1,networks.score_threshold=0.2,labels=indoor", "enet")
        self.assertEqual(variant.prediction_settings(), ["networks.score_threshold=0.2", "labels=indoor"])

    def test_refuses_what_it_does_not_know(self):
        for bad in ("a:tracker", "a:colour=green"):
            with self.assertRaises(tool.Failure):
                tool.parse_variant(bad, "enet")
        with self.assertRaises(tool.Failure):
            tool.network_arguments("enet+resnet")

    def test_a_missing_ablation_file_is_one_line_and_exit_code_1(self):
        result = subprocess.run([sys.executable, TOOL, "--ablation", "absent.toml"], capture_output=True, text=True, check=False)
        self.assertEqual(result.returncode, 1)
        self.assertEqual(result.stderr, "score_recordings: cannot read absent.toml: No such file or directory\n")


class Moves(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        (self.root / "from").mkdir()

    def move(self, files):
        for name, text in files.items():
            (self.root / "from" / name).write_text(text)
        return tool.copy_moved(self.root / "from", self.root / "to", [1.0, 2.0, -3.0])

    def test_poses_in_lines_of_16_and_of_4_move_alike(self):
        pose = [1, 0, 0, 0.25, 0, 1, 0, 0.5, 0, 0, 1, 0.75, 0, 0, 0, 1]
        rows = "".join(" ".join(map(str, pose[i:i + 4])) + "\n" for i in range(0, 16, 4))
        target = self.move({"poses.txt": 2 * (" ".join(map(str, pose)) + "\n"), "frame-000000.pose.txt": rows})
        self.assertEqual(translations((target / "poses.txt").read_text()), 2 * [[1.25, 2.5, -2.25]])
        self.assertEqual(translations((target / "frame-000000.pose.txt").read_text()), [[1.25, 2.5, -2.25]])

    def test_clicks_move_with_the_camera_and_images_are_links(self):
        target = self.move({"clicks.json": json.dumps({"points": [{"xyz": [0.5, 0.5, 0.5], "class": "cup"}]}), "a.png": "pixels"})
        point = json.loads((target / "clicks.json").read_text())["points"][0]
        self.assertEqual(point, {"xyz": [1.5, 2.5, -2.5], "class": "cup"})
        self.assertTrue((target / "a.png").is_symlink())
        self.assertEqual((target / "a.png").read_text(), "pixels")


class Tables(unittest.TestCase):
    def records(self):
        names = [*tables.SCORES, *tables.COUNTS, "fusion p50 ms", "peak MB"]
        values = {("a", "kitchen", 0): 0.5, ("a", "kitchen", 1): 0.7, ("a", "hololens", 0): 0.1, ("a", "hololens", 1): 0.3,
                  ("b", "kitchen", 0): 0.9, ("b", "kitchen", 1): 0.9, ("b", "hololens", 0): 0.4, ("b", "hololens", 1): 0.2}
        return {key: dict.fromkeys(names, value) for key, value in values.items()}

    def test_the_average_over_recordings_is_taken_move_by_move(self):
        results = tables.summarise(self.records(), ["a", "b"], ["kitchen", "hololens"], range(2))
        j = results["average"]["b"]["J"]
        self.assertAlmostEqual(j["mean"], 0.6)
        self.assertAlmostEqual(j["min"], 0.55)  # the second move, not the least of each recording
        self.assertAlmostEqual(j["max"], 0.65)

    def test_values_show_their_spread_and_differences_their_sign(self):
        kitchen = tables.summarise(self.records(), ["a", "b"], ["kitchen"], range(2))["kitchen"]
        self.assertIn("| a | 60.0 (50.0..70.0) |", tables.table(kitchen, ["J"]))
        self.assertIn("| b | 90.0 |", tables.table(kitchen, ["J"]))
        self.assertIn("| b | +30.0 |", tables.differences(kitchen))

    def test_what_one_run_lacks_is_not_averaged(self):
        records = self.records()
        records["a", "kitchen", 1]["things"] = None
        kitchen = tables.summarise(records, ["a", "b"], ["kitchen"], range(2))["kitchen"]
        self.assertIsNone(kitchen["a"]["things"])
        self.assertIn("| a | – |", tables.table(kitchen, ["things"]))


@unittest.skipUnless(PROGRAM and (SHARED / "data/kitchen").is_dir(), "needs the program and the shared recordings")
class Kitchen(unittest.TestCase):
    def test_predicts_once_and_maps_moved_recordings(self):
        with tempfile.TemporaryDirectory() as root:
            root = pathlib.Path(root)
            command = [sys.executable, TOOL, "a:networks=yolo,map.voxel_size_m=0.05",
                       "b:networks=yolo,map.voxel_size_m=0.05,tracker.iou_threshold=0.5", "--recordings", "kitchen",
                       "--frames", "0:9:3", "--moves", "2", "--program", PROGRAM, "--out", root / "out", "--json", root / "scores.json"]
            result = subprocess.run(command, capture_output=True, text=True, check=False)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(result.stderr.count("predicting"), 1)
            scores = json.loads((root / "scores.json").read_text())
            hashes = {json.loads(p.read_text())["map_hash"] for p in (root / "out").glob("a/*/report.json")}
        self.assertEqual(len(hashes), 2)  # a moved recording meets other voxels
        self.assertEqual(len(scores["runs"]), 4)
        coverage = [run["coverage"] for run in scores["runs"]]
        self.assertGreater(min(coverage), 0.2)  # clicks moved with the map, else nothing would lie within 5 cm
        self.assertLess(max(coverage) - min(coverage), 0.05)


if __name__ == "__main__":
    unittest.main()
