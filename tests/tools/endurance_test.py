# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""A small sample of the endurance run, and the same by way of a list of recordings: endurance_test.py PANOPTIC_BENCH."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

PROGRAM = sys.argv.pop() if len(sys.argv) > 1 else None
ROOM = "sim:1,rooms=1,frames=8"
# Networks that err see a cat now and then, and a thing of a mobile class hides the surface of its frame: in 8 frames that shows.
SMALL = ("--set", "moving.classes=false", "--resize", "0.25", "--set", "map.voxel_size_m=0.05", "--set", "objects.every_frames=10", "--set", "regularizer.every_frames=40")


def endured(folder, recording, *arguments):
    result = folder / "result.json"
    subprocess.run([PROGRAM, recording, "--json", result, *SMALL, *arguments], check=True, capture_output=True)
    return json.loads(result.read_text(encoding="utf-8"))


class Endurance(unittest.TestCase):
    def test_a_room_seen_again_and_again_takes_no_more_memory_time_or_disk(self):
        with tempfile.TemporaryDirectory() as scratch:
            folder = pathlib.Path(scratch)
            looks = endured(folder, ROOM, "--endurance", "480", "--look-every", "60", "--save", folder / "map.panoptic")["looks"]
        self.assertEqual([look["frames"] for look in looks], list(range(60, 481, 60)))
        early, late = looks[1], looks[-1]
        self.assertGreater(early["observed_voxels"], 1000)
        self.assertLess(late["observed_voxels"], 1.05 * early["observed_voxels"])
        self.assertLess(late["map_mb"], 1.05 * early["map_mb"])
        self.assertLess(late["rss_mb"] - early["rss_mb"], 4)
        self.assertLess(late["objects"], 2 * early["objects"] + 10)
        poses_mb = (late["frames"] - early["frames"]) * 150e-6  # up to 20,000 are listed
        self.assertLess(late["file_mb"] - poses_mb, 1.2 * early["file_mb"])
        # Of the processor's time, which others on the machine disturb: a cost that grows with the frames would be eight times.
        self.assertLess(late["cpu_ms"], 3 * early["cpu_ms"])

    def test_two_rooms_beside_each_other_that_are_read_on_the_way_are_twice_the_map(self):
        with tempfile.TemporaryDirectory() as scratch:
            folder = pathlib.Path(scratch)
            rooms = folder / "rooms.toml"
            rooms.write_text("".join(f'[[recording]]\npath = "{ROOM}"\ntranslation = [{20 * i}, 0, 0]\n' for i in range(2)), encoding="utf-8")
            looks = endured(folder, rooms, "--endurance", "1000", "--streamed", "--look-every", "8")["looks"]
        self.assertEqual([look["frames"] for look in looks], [8, 16])
        self.assertAlmostEqual(looks[1]["observed_voxels"] / looks[0]["observed_voxels"], 2, delta=0.05)


if __name__ == "__main__":
    unittest.main()
