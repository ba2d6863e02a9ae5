# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Poses that are found, what moved, and what the map remembers of objects that are gone."""
import unittest

import numpy as np

import panoptic as pf
from home import COARSE, LABELS, arrays, mapped, scratch

MOBILE = pf.LabelSet("mobile", [pf.LabelClass(1, "wall", is_thing=False), pf.LabelClass(3, "chair"),
                                pf.LabelClass(5, "person", is_mobile=True)])


def tracked(dataset, frames):
    """What a tracker makes of the first frames, beginning with the true pose."""
    tracker = pf.CameraTracker(start=dataset[0].pose)
    mapper = pf.Mapper(pf.Options(map={"voxel_size_m": 0.04}))
    states = []
    for frame in dataset.frames(f"0:{frames}"):
        found = tracker.track(frame.with_pose(np.eye(4)), mapper)
        states.append(found.state)
        if found:
            frame = frame.with_pose(found.pose)
            assert mapper.add(frame)
            tracker.keep(frame)
    return tracker, states


class Tracking(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.dataset = pf.open_dataset("sim:5,rooms=1,frames=720,noise=none")
        cls.tracker, cls.states = tracked(cls.dataset, 12)
        cls.truth = (np.array([cls.dataset[i].time_s for i in range(12)]), np.array([cls.dataset[i].pose for i in range(12)]))

    def test_poses_are_those_of_the_truth(self):
        self.assertEqual(self.states, ["begun"] + ["tracked"] * 11)
        times, poses = self.tracker.trajectory()
        np.testing.assert_array_equal(times, self.truth[0])
        np.testing.assert_allclose(poses[:, :3, 3], self.truth[1][:, :3, 3], atol=0.02)
        self.assertGreaterEqual(self.tracker.keyframes, 1)
        self.assertEqual((self.tracker.loops, self.tracker.corrected_poses()), ([], None))

    def test_scores_of_a_trajectory_are_those_of_its_file(self):
        times, poses = self.tracker.trajectory()
        scores = pf.score_trajectory((times, poses), self.truth)
        self.assertEqual((scores["poses"], scores["absolute_m"]["count"]), (12, 12))
        apart = np.linalg.norm(poses[:, :3, 3] - self.truth[1][:, :3, 3], axis=1)
        self.assertLessEqual(scores["absolute_m"]["rmse"], np.sqrt(np.mean(apart ** 2)) + 1e-12)  # after alignment
        still = scratch() / "still.txt"
        still.write_text("# time tx ty tz qx qy qz qw\n" + "".join(f"{t} {i} 0 {i * i} 0 0 0 1\n" for i, t in enumerate(times)))
        read = pf.read_trajectory(still)
        np.testing.assert_array_equal(read[1][:, 0, 3], np.arange(12))
        self.assertAlmostEqual(pf.score_trajectory(still, read)["absolute_m"]["most"], 0)

    def test_lost_cameras_are_not_kept(self):
        tracker, mapper = pf.CameraTracker(), pf.Mapper(pf.Options(**COARSE))
        dark = arrays() | {"depth": np.zeros((120, 160), np.float32)}
        found = tracker.track(pf.Frame(**dark), mapper)
        self.assertFalse(found)
        self.assertEqual((found.state, found.pose), ("lost", None))
        self.assertTrue(found.reason)
        with self.assertRaisesRegex(pf.Error, "lost, or kept already"):
            tracker.keep(pf.Frame(**dark))

    def test_only_the_frame_that_was_tracked_is_kept(self):
        tracker, mapper = pf.CameraTracker(), pf.Mapper(pf.Options(**COARSE))
        first, second = self.dataset[0], self.dataset[1]
        self.assertTrue(tracker.track(first, mapper))
        with self.assertRaisesRegex(pf.Error, "not the frame that was tracked"):
            tracker.keep(second)
        tracker.keep(first.with_pose(np.eye(4)))
        with self.assertRaisesRegex(pf.Error, "kept already"):
            tracker.keep(first)

    def test_wrong_trajectories_are_refused(self):
        times, poses = self.truth
        for wrong, words in [((times[:2], poses), "2 times and poses"), (None, "must be"), ((times[:, None], poses), "times of"),
                             ((times * np.nan, poses), "time 0 is not finite"),
                             ((times,), "must be"), (scratch() / "none.txt", "none.txt")]:
            with self.assertRaisesRegex(pf.Error, words):
                pf.score_trajectory(wrong, self.truth)
        with self.assertRaisesRegex(pf.Error, "step_s"):
            pf.score_trajectory(self.truth, self.truth, step_s=0)
        with self.assertRaisesRegex(pf.Error, "finite"):
            pf.score_trajectory(self.truth, self.truth, most_apart_s=float("inf"))
        self.assertEqual(pf.score_trajectory([times, poses], self.truth)["absolute_m"]["count"], 12)
        short = pf.score_trajectory(self.truth, self.truth)["relative_m"]
        self.assertEqual((short["count"], short["rmse"]), (0, None))
        with self.assertRaisesRegex(pf.Error, "start"):
            pf.CameraTracker(start=np.zeros((4, 4)))

    def test_recordings_need_no_poses(self):
        pf.simulate(scratch() / "with_poses", seed=3, rooms=1, frames=2, noise="none", truth_stride=8)
        posed = pf.open_dataset(scratch() / "with_poses")
        bare = pf.open_dataset(scratch() / "with_poses", poses=False)
        self.assertEqual(len(bare), len(posed))
        np.testing.assert_array_equal(bare[1].pose, np.eye(4))
        np.testing.assert_array_equal(bare[1].depth, posed[1].depth)


class Weights(unittest.TestCase):
    def test_what_a_reading_counts(self):
        frame = arrays()
        half = np.full(frame["depth"].shape, 0.5, np.float32)
        weights = []
        for weight in (None, half):
            mapper = pf.Mapper(pf.Options(**COARSE), labels=LABELS)
            made = pf.Frame(**frame, depth_weight=weight)
            self.assertTrue(mapper.add(made))
            weights.append(mapper.map.at([0, 0, 2]).weight)
        self.assertIs(pf.Frame(**frame).depth_weight, None)
        self.assertEqual(made.depth_weight.ctypes.data, half.ctypes.data)
        self.assertAlmostEqual(weights[0], 2 * weights[1])

    def test_wrong_weights(self):
        mapper = pf.Mapper(pf.Options(**COARSE), labels=LABELS)
        for wrong in (np.zeros((120, 160), np.float32), np.full((120, 160), 2, np.float32), np.ones((2, 2), np.float32)):
            self.assertIn("weight", mapper.add(pf.Frame(**arrays(), depth_weight=wrong)).reason)
            self.assertIn("weight", mapper.add(**arrays(), depth_weight=wrong).reason)
        with self.assertRaisesRegex(pf.Error, "must be float32"):
            pf.Frame(**arrays(), depth_weight=np.ones((120, 160)))

    def test_other_poses_share_the_images(self):
        frame = pf.Frame(**arrays())
        pose = np.eye(4)
        pose[2, 3] = 7
        moved = frame.with_pose(pose)
        del frame
        np.testing.assert_array_equal(moved.pose, pose)
        self.assertEqual(float(moved.depth[0, 0]), 2.0)
        with self.assertRaises(pf.Error):
            moved.with_pose(np.full((4, 4), np.nan))


def seen(i, box, label):
    """A frame of the wall, with something 1.2 m before the camera if `box`, and its mask."""
    frame = arrays(3 * i)
    frame["index"], frame["time_s"] = 3 * i, i / 10
    ids = np.ones((120, 160), np.uint8)
    if box:
        frame["depth"][40:90, 60:110] = 1.2
        ids[40:90, 60:110] = 2
    return frame, (ids, ["wall", label])


class Changes(unittest.TestCase):
    def test_people_have_tracks_and_no_surface(self):
        mapper = pf.Mapper(pf.Options(**COARSE), labels=MOBILE)
        for i in range(6):
            frame, segments = seen(i, True, "person")
            self.assertTrue(mapper.add(**frame, segments=segments))
        track, = mapper.moving_tracks()
        self.assertEqual((track["class_name"], list(track["frames"])), ("person", list(range(0, 18, 3))))
        self.assertEqual((track["min_m"].shape, track["times_s"].shape), ((6, 3), (6,)))
        self.assertTrue(np.all(np.abs(track["min_m"][:, 2] - 1.2) < 0.06), track["min_m"])
        self.assertEqual(mapper.map.objects("person"), [])

    def test_objects_that_are_gone_are_remembered(self):
        mapper = pf.Mapper(pf.Options(**COARSE), labels=MOBILE)
        for i in range(60):
            frame, segments = seen(i, i < 15, "chair")
            mapper.add(**frame, segments=segments)
        mapper.finish()
        self.assertEqual(mapper.map.objects("chair"), [])
        chair, = mapper.map.history()
        self.assertEqual((chair["class_name"], chair["first_s"], chair["moved_to"]), ("chair", 0, None))
        self.assertGreater(chair["gone_s"], 1.4)
        self.assertEqual([o["id"] for o in mapper.map.history(when=1.0)], [chair["id"]])
        self.assertEqual(mapper.map.history(when=5.9), [])
        self.assertEqual(mapper.map.history(changes_since=chair["gone_s"]), [])
        self.assertEqual(len(mapper.map.history(changes_since=0)), 1)
        mapper.save(scratch() / "gone.panoptic")
        saved, = pf.load_map(scratch() / "gone.panoptic").history()
        for name in ("id", "first_s", "gone_s"):
            self.assertEqual(saved[name], chair[name], name)

    def test_objects_that_stayed(self):
        spans = mapped().map.history()
        self.assertEqual([span["id"] for span in spans], [o.id for o in mapped().map.objects()])
        self.assertEqual({(span["gone_s"], span["appeared"]) for span in spans}, {(None, False)})
        self.assertEqual(mapped().map.history(when=-1), [])
        for wrong in (dict(when=1, changes_since=1), dict(when=float("nan"))):
            with self.assertRaises(pf.Error):
                mapped().map.history(**wrong)


if __name__ == "__main__":
    unittest.main()
