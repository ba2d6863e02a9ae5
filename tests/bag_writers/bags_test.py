# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""bags_test.py PANOPTIC: bags by independent writers become the map that the folder they were made of becomes."""

import json
import struct
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import room
import writers

PANOPTIC = sys.argv.pop(1) if len(sys.argv) > 1 else "build/release/panoptic"
SKIPPED = 77  # for CTest: something was not tried, and nothing failed
HAS_ROSBAG = writers.has_rosbag()
NO_ROSBAG = "python3-rosbag, python3-sensor-msgs, python3-nav-msgs and python3-tf2-msgs are not installed: run scripts/setup --packages-only"
NO_MCAP = "@mcap/core is not installed: run scripts/setup --packages-only"


class Bags(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.scratch.name)
        calibration = room.write_tum(cls.folder / "tum")
        cls.expected = cls.map_of(cls.folder / "tum", "--calibration", str(calibration))

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    @classmethod
    def call(cls, *arguments):
        return subprocess.run([PANOPTIC, *map(str, arguments)], capture_output=True, text=True, check=False)

    @classmethod
    def map_of(cls, recording, *more):
        out = cls.folder / "out"
        done = cls.call("run", recording, "-o", out, "--set", "map.voxel_size_m=0.08", "--no-pictures", "--threads", "2", *more)
        if done.returncode != 0:
            raise AssertionError(done.stderr)
        report = json.loads((out / "report.json").read_text())
        return report["map_hash"], report["frames"]["used"]

    def expect_same(self, path, *more):
        self.assertEqual(self.map_of(path, *more), self.expected, path)
        self.assertEqual(self.expected[1], room.FRAMES)

    def refusal(self, path, *more):
        done = self.call("run", path, "-o", self.folder / "out", *more)
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        return done.stderr

    def test_rosbag2_sqlite(self):
        path = self.folder / "room.db3"
        writers.write_db3(path, room.messages())
        self.expect_same(path)
        self.assertIn("info=/tf: its messages are tf2_msgs/TFMessage", self.refusal(path, "--topics", "info=/tf"))
        listing = json.loads(self.call("info", path, "--json").stdout)
        self.assertEqual({t["name"]: t["role"] for t in listing["topics"]},
                         {"/camera/depth/image": "depth", "/camera/rgb/image": "color", "/tf": "pose",
                          "/camera/depth/camera_info": "info", "/camera/rgb/camera_info": "info"})

    def test_big_endian_messages(self):
        path = self.folder / "big.db3"
        writers.write_db3(path, room.messages("compressedDepth", "png", "odometry"), big=True)
        self.expect_same(path)

    def test_parts_of_one_bag_in_a_folder(self):
        folder = self.folder / "parts"
        folder.mkdir()
        messages = room.messages()
        writers.write_db3(folder / "parts_0.db3", messages[:31])
        writers.write_db3(folder / "parts_1.db3", messages[31:])
        self.expect_same(folder)

    def test_mcap(self):
        messages = room.messages("16UC1", "bgra8", "odometry")
        for compression in ("none", "lz4", "zstd"):
            for indexed in (True, False):
                with self.subTest(compression=compression, indexed=indexed):
                    path = self.folder / f"{compression}_{indexed}.mcap"
                    if not writers.write_mcap(path, messages, compression, indexed):
                        self.skipTest(NO_MCAP)
                    self.expect_same(path)

    def test_mcap_that_was_not_closed(self):
        path = self.folder / "open.mcap"
        if not writers.write_mcap(path, room.messages(), "zstd"):
            self.skipTest(NO_MCAP)
        # What the last chunk before the summary ends with: the summary begins where the footer says.
        data = path.read_bytes()
        summary = struct.unpack("<Q", data[-8 - 20:-8 - 12])[0]
        path.write_bytes(data[:summary])
        self.expect_same(path)

    @unittest.skipUnless(HAS_ROSBAG, NO_ROSBAG)
    def test_ros1(self):
        kinds = {"none": ("16UC1", "rgb8", "tf"), "bz2": ("compressedDepth", "bgr8", "pose"), "lz4": ("32FC1", "png", "odometry")}
        for compression, kind in kinds.items():
            with self.subTest(compression=compression):
                path = self.folder / f"{compression}.bag"
                writers.write_ros1(path, room.messages(*kind), compression)
                self.expect_same(path)

    @unittest.skipUnless(HAS_ROSBAG, NO_ROSBAG)
    def test_ros1_that_was_not_closed(self):
        path = self.folder / "open.bag"
        writers.write_ros1(path, room.messages(), "lz4")
        data = bytearray(path.read_bytes())
        at = data.index(b"index_pos=") + len(b"index_pos=")
        index = struct.unpack("<Q", data[at:at + 8])[0]
        data[at:at + 8] = bytes(8)
        path.write_bytes(data[:index])
        self.expect_same(path)

    @unittest.skipUnless(HAS_ROSBAG, NO_ROSBAG)
    def test_ros1_parts(self):
        folder = self.folder / "ros1_parts"
        folder.mkdir()
        messages = room.messages()
        writers.write_ros1(folder / "room_0.bag", messages[:31])
        writers.write_ros1(folder / "room_1.bag", messages[31:])
        self.expect_same(folder)

    def test_poses_between_images_are_interpolated_and_lenses_straightened(self):
        shift_ns, lens = 13_000_000, [-0.2, 0.05, 0.001, -0.002, 0.0]
        tum = self.folder / "shifted"
        calibration = self.folder / "lens.toml"
        room.write_tum(tum, shift_ns)
        text = (self.folder / "room.toml").read_text().replace("distortion = []", f"distortion = {lens}")
        calibration.write_text(text)
        expected = self.map_of(tum, "--calibration", str(calibration))
        self.assertNotEqual(expected, self.expected)
        messages = room.messages()
        for time, topic, kind, fields in messages:
            if kind == "sensor_msgs/CameraInfo":
                fields["d"] = lens
            for transform in fields.get("transforms", []):
                transform["header"]["stamp"] += shift_ns
        path = self.folder / "shifted.db3"
        writers.write_db3(path, messages)
        self.assertEqual(self.map_of(path), expected)

    def test_a_copy_beside_a_bag_is_refused(self):
        folder = self.folder / "copies"
        folder.mkdir()
        writers.write_db3(folder / "a.db3", room.messages())
        writers.write_db3(folder / "b.db3", room.messages())
        self.assertIn("a.db3 and b.db3 hold images of one topic at one time", self.refusal(folder))

    def test_what_was_cut_off_in_its_first_bytes_says_so(self):
        path = self.folder / "cut.mcap"
        if not writers.write_mcap(path, room.messages(), "zstd"):
            self.skipTest(NO_MCAP)
        path.write_bytes(path.read_bytes()[:5000])
        error = self.refusal(path)
        self.assertIn("it holds no messages (left out: ", error)
        self.assertIn("cut off", error)

    def test_topics_are_chosen_where_there_are_several(self):
        path = self.folder / "two.db3"
        messages = room.messages()
        messages += [(time, "/other" + topic, kind, fields) for time, topic, kind, fields in messages if "depth" in topic]
        writers.write_db3(path, sorted(messages, key=lambda m: m[0]))
        error = self.refusal(path)
        self.assertIn("/camera/depth/image (sensor_msgs/Image, 16UC1)", error)
        self.assertIn("/other/camera/depth/image", error)
        self.expect_same(path, "--topics", "depth=/camera/depth/image")
        self.assertIn("/nowhere", self.refusal(path, "--topics", "depth=/nowhere"))
        self.assertEqual(self.call("run", path, "-o", self.folder / "out", "--topics", "depth").returncode, 2)

    def test_what_is_lacking_is_named(self):
        messages = room.messages()

        def refused(kept):
            path = self.folder / "less.db3"
            path.unlink(missing_ok=True)
            writers.write_db3(path, [m for m in messages if kept(m)])
            return self.refusal(path)

        self.assertIn("no depth images", refused(lambda m: m[1] != "/camera/depth/image"))
        self.assertIn("no colour images", refused(lambda m: m[1] != "/camera/rgb/image"))
        self.assertIn("no CameraInfo beside the depth images", refused(lambda m: "camera_info" not in m[1]))

    def test_without_poses_the_camera_is_tracked(self):
        path = self.folder / "poseless.db3"
        writers.write_db3(path, [m for m in room.messages() if m[1] != "/tf"])
        done = self.call("run", path, "-o", self.folder / "tracked", "--set", "map.voxel_size_m=0.08", "--no-pictures", "--threads", "2")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("the camera is tracked", done.stdout)
        self.assertEqual(json.loads((self.folder / "tracked/report.json").read_text())["frames"]["used"], room.FRAMES)
        self.assertIn("holds no poses", self.call("doctor", path).stderr)

    def test_frames_that_are_not_connected_are_named(self):
        messages = room.messages(poses="odometry")
        for message in messages:
            if "child" in message[3]:
                message[3]["child"] = "base_link"
        path = self.folder / "loose.db3"
        writers.write_db3(path, messages)
        error = self.refusal(path)
        self.assertIn("'base_link'", error)
        self.assertIn(room.CAMERA, error)


def main():
    result = unittest.main(exit=False).result
    for reason in sorted({reason for _, reason in result.skipped}):
        print(f"SKIPPED in part: {reason}", file=sys.stderr)
    if not result.wasSuccessful():
        return 1
    return SKIPPED if result.skipped else 0


if __name__ == "__main__":
    sys.exit(main())
