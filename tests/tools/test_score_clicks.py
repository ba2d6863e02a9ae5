# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""tools/score_clicks.py gives the scores that one can work out by hand."""
import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

TOOL = pathlib.Path(__file__).resolve().parents[2] / "tools" / "score_clicks.py"
LABELS = [{"id": 1, "name": "wall", "is_thing": False, "color": [1, 2, 3]}, {"id": 2, "name": "floor", "is_thing": False, "color": [1, 2, 3]},
          {"id": 3, "name": "chair", "is_thing": True, "color": [1, 2, 3]}, {"id": 4, "name": "table", "is_thing": True, "color": [1, 2, 3]}]
CLASS_ID = {"unknown": 0, **{entry["name"]: entry["id"] for entry in LABELS}}
HEADER = ("ply\nformat binary_little_endian 1.0\ncomment test\nelement vertex {}\n"
          + "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz"))
          + "".join(f"property uchar {name}\n" for name in ("red", "green", "blue"))
          + "property ushort class_id\nproperty ushort panoptic_id\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n")


def click(x, name, obj=None, also=(), ok=None):
    return {"frame": 0, "u": 0, "v": 0, "xyz": [x, 0.0, 0.0], "class": name, "also": list(also), "object": obj,
            "instance_ok": obj is not None if ok is None else ok}


class ScoreClicks(unittest.TestCase):
    """Vertices lie on the x axis, 1 m apart, so that a click at x belongs to vertex x."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        (self.root / "report.json").write_text(json.dumps({"labels": LABELS}))

    def write_mesh(self, vertices):
        """vertices: (x, class name, panoptic id)."""
        data = HEADER.format(len(vertices)).encode()
        for x, name, panoptic_id in vertices:
            data += struct.pack("<6f3BHH", x, 0, 0, 0, 0, 1, 9, 9, 9, CLASS_ID[name], panoptic_id)
        (self.root / "mesh.ply").write_bytes(data)

    def run_tool(self, *arguments):
        command = [sys.executable, TOOL, self.root, self.root / "clicks.json", *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    def scores(self, vertices, points, *arguments):
        self.write_mesh(vertices)
        (self.root / "clicks.json").write_text(json.dumps({"points": points}))
        result = self.run_tool("--json", self.root / "scores.json", *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads((self.root / "scores.json").read_text())

    def refusal(self, *arguments):
        result = self.run_tool(*arguments)
        self.assertEqual(result.returncode, 1, result.stdout)
        self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
        return result.stderr

    def test_a_point_is_covered_up_to_the_distance_and_by_the_nearest_vertex(self):
        vertices = [(0, "wall", 1), (0.06, "floor", 2), (5, "wall", 1)]
        points = [click(0.02, "wall"), click(0.04, "floor"), click(4.951, "wall"), click(4.94, "wall"), click(-3, "wall")]
        s = self.scores(vertices, points)
        self.assertEqual((s["covered"], s["points"]), (3, 5))
        self.assertEqual(s["classes"]["wall"]["right"], 2)
        self.assertEqual(s["classes"]["floor"]["right"], 1)
        self.assertEqual(self.scores(vertices, points, "--max-distance", "0.1")["covered"], 4)

    def test_class_accuracy_is_averaged_over_classes(self):
        vertices = [(0, "wall", 1), (1, "wall", 1), (2, "floor", 2), (3, "unknown", 0), (4, "chair", 5), (5, "table", 6), (6, "table", 6)]
        points = [click(0, "wall"), click(1, "wall"), click(2, "wall"), click(3, "wall"),  # half of the wall right
                  click(2, "floor"),                                                      # all of the floor
                  click(4, "chair"), click(5, "chair"), click(6, "chair"), click(3, "chair")]  # a quarter of the chair
        s = self.scores(vertices, points)
        self.assertAlmostEqual(s["stuff_accuracy"], (0.5 + 1) / 2)
        self.assertAlmostEqual(s["thing_accuracy"], 0.25)
        self.assertAlmostEqual(s["class_accuracy"], (0.5 + 1 + 0.25) / 3)
        self.assertEqual(s["classes"]["chair"]["mistaken_for"], {"table": 2, "unknown": 1})

    def test_classes_in_also_are_right_and_stand_in_for_a_class_that_the_label_set_lacks(self):
        vertices = [(0, "table", 5), (1, "table", 5), (2, "unknown", 0)]
        points = [click(0, "chair", also=["table"]),           # counted as chair, right
                  click(1, "desk", also=["counter", "table"]),  # counted as table, right
                  click(2, "desk", also=["table"]),             # counted as table, wrong
                  click(0, "plant"), click(1, "plant", also=["bag"])]  # not counted
        s = self.scores(vertices, points)
        self.assertEqual({k: (v["right"], v["points"]) for k, v in s["classes"].items()}, {"chair": (1, 1), "table": (1, 2)})
        self.assertEqual(s["class_scored_points"], 3)

    def test_pairs_count_the_same_id_against_the_same_name(self):
        vertices = [(0, "chair", 5), (1, "chair", 5), (2, "chair", 6), (3, "unknown", 0), (4, "unknown", 0), (5, "chair", 6)]
        points = [click(0, "chair", "a"), click(1, "chair", "a"), click(2, "chair", "a"), click(5, "chair", "b"),
                  click(3, "chair", "b"), click(4, "chair", "b"), click(0, "chair", "c", ok=False), click(9, "chair", "a")]
        pairs = self.scores(vertices, points)["pairs"]
        # Same id: (0, 1) and (2, 5). Same name: 3 pairs of a, 3 of b. Both: (0, 1). Two unknown points are no pair.
        self.assertAlmostEqual(pairs["precision"], 1 / 2)
        self.assertAlmostEqual(pairs["recall"], 1 / 6)
        self.assertAlmostEqual(pairs["f1"], 2 * 1 / (2 + 6))

    def test_an_object_is_found_if_its_majority_id_is_a_things_and_its_own(self):
        ids = {"alone": (5, 5, 6), "sharing_1": (7, 7, 7), "sharing_2": (7, 7, 8), "in_the_wall": (1, 1, 1), "unknown": (0, 0, 9),
               "too_few": (10, 10)}
        vertices, points = [], []
        for name, object_ids in ids.items():
            for panoptic_id in object_ids:
                vertices.append((len(vertices), "chair", panoptic_id))
                points.append(click(len(vertices) - 1, "chair", name))
        s = self.scores(vertices, points)
        self.assertEqual(s["objects"]["found"], ["alone"])
        self.assertEqual(s["objects"]["missed"], ["in_the_wall", "sharing_1", "sharing_2", "unknown"])
        self.assertAlmostEqual(s["objects"]["share"], 1 / 5)
        self.assertEqual(s["objects_in_map"], 6)  # 5 to 10
        self.assertEqual(s["named_objects"], 6)

    def test_j_is_the_mean_of_four_scores(self):
        vertices = [(0, "wall", 1), (1, "chair", 5), (2, "chair", 5), (3, "unknown", 0)]
        points = [click(0, "wall"), click(3, "wall"), click(1, "chair", "a"), click(2, "chair", "a"), click(1.01, "chair", "a"), click(3, "chair", "a")]
        s = self.scores(vertices, points)
        self.assertAlmostEqual(s["stuff_accuracy"], 0.5)
        self.assertAlmostEqual(s["thing_accuracy"], 0.75)
        self.assertAlmostEqual(s["pairs"]["f1"], 2 * 3 / (3 + 6))
        self.assertAlmostEqual(s["objects"]["share"], 1)
        self.assertAlmostEqual(s["J"], (0.5 + 0.75 + 6 / 9 + 1) / 4)

    def test_scores_without_points_are_absent_rather_than_zero(self):
        s = self.scores([(0, "wall", 1)], [click(0, "wall"), click(50, "chair", "a")])
        self.assertEqual(s["stuff_accuracy"], 1)
        self.assertIsNone(s["thing_accuracy"])
        self.assertIsNone(s["pairs"]["f1"])
        self.assertIsNone(s["J"])
        self.assertIn("n/a", self.run_tool().stdout)

    def test_the_table_names_every_class_and_its_confusion(self):
        self.scores([(0, "table", 5), (1, "chair", 6)], [click(0, "chair", "a"), click(1, "chair", "a")])
        text = self.run_tool().stdout
        self.assertRegex(text, r"chair +thing +2 +1 +50\.0% +table 1")
        self.assertRegex(text, r"coverage +100\.0%")
        self.assertRegex(text, r"objects in the map 2, named in the clicks 1")

    def test_missing_and_broken_files_are_named_in_one_line(self):
        self.assertIn("mesh.ply", self.refusal_without("mesh.ply"))
        self.assertIn("report.json", self.refusal_without("report.json"))
        self.assertIn("clicks.json", self.refusal_without("clicks.json"))
        self.prepare()
        (self.root / "report.json").write_text('{"stages": {}}')
        self.assertIn("labels", self.refusal())
        self.prepare()
        (self.root / "clicks.json").write_text('{"points": [{"class": "wall"}]}')
        self.assertIn("clicks.json", self.refusal())
        (self.root / "clicks.json").write_text('{"points": [')
        self.assertIn("not JSON", self.refusal())
        self.prepare()
        self.assertIn("scores.json", self.refusal("--json", self.root / "absent" / "scores.json"))

    def test_meshes_that_cannot_be_read_are_refused(self):
        self.prepare()
        good = (self.root / "mesh.ply").read_bytes()
        for bad, word in ((good[:-1], "cut off"), (good[:40], "PLY"), (b"solid", "PLY"), (good.replace(b"binary_little_endian", b"ascii"), "binary"),
                          (good.replace(b"panoptic_id", b"instance_id"), "panoptic_id"), (good.replace(b"float nx", b"strange nx"), "strange")):
            (self.root / "mesh.ply").write_bytes(bad)
            self.assertIn(word, self.refusal())
        self.write_mesh([(float("nan"), "wall", 1)])
        self.assertIn("not finite", self.refusal())

    def test_wrong_usage_exits_with_2(self):
        self.prepare()
        self.assertEqual(self.run_tool("--max-distance", "0").returncode, 2)
        self.assertEqual(self.run_tool("--max-distance", "nan").returncode, 2)

    def prepare(self):
        (self.root / "report.json").write_text(json.dumps({"labels": LABELS}))
        self.scores([(0, "wall", 1)], [click(0, "wall")])

    def refusal_without(self, name):
        self.prepare()
        (self.root / name).unlink()
        return self.refusal()


if __name__ == "__main__":
    unittest.main()
