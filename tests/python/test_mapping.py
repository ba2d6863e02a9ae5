# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Mapping from Python gives the map that the program gives, and shows it without copies."""
import gc
import json
import os
import pathlib
import resource
import threading
import time
import unittest

import numpy as np

import panoptic as pf
from home import (COARSE, LABELS, PROGRAM, SOURCE, arrays, home, ids_of, mapped, release_only, run_program, scratch, shared,
                  small_mapper)


def address(array):
    return array.__array_interface__["data"][0]


class SameMap(unittest.TestCase):
    @unittest.skipUnless(PROGRAM, "needs the program")
    def test_hash_is_that_of_the_program(self):
        run_program("run", home(), "--predictions", home() / "predictions", "--set", "map.voxel_size_m=0.05", "--no-pictures",
                    "-o", scratch() / "run")
        report = json.loads((scratch() / "run/report.json").read_text())
        self.assertEqual(mapped().map_hash(), report["map_hash"])
        self.assertEqual(mapped().frames["used"], report["frames"]["used"])
        self.assertGreater(mapped().frames["labelled"], 0)

    @unittest.skipUnless(PROGRAM, "needs the program")
    def test_hash_of_a_real_recording_with_networks_is_that_of_the_program(self):
        kitchen, _ = shared("data/kitchen"), shared("models/enet_scannet_nyu40")
        settings = {"map": {"voxel_size_m": 0.05}, "networks": {"semantic": str(SOURCE / "configs/models/enet_scannet_nyu40.toml")}}
        seen, out = scratch() / "kitchen_seen", scratch() / "kitchen"
        calibration = SOURCE / "configs/kitchen.toml"
        run_program("predict", kitchen, "--calibration", calibration, "--frames", "100:160:20", "--set",
                    f"networks.semantic={settings['networks']['semantic']}", "-o", seen)
        run_program("run", kitchen, "--calibration", calibration, "--frames", "100:160:20", "--predictions", seen, "--set",
                    "map.voxel_size_m=0.05", "--no-pictures", "-o", out)
        expected = json.loads((out / "report.json").read_text())
        for predictor in (pf.file_predictor(seen), pf.make_predictor(pf.Options(**settings))):
            mapper = pf.Mapper(pf.Options(**COARSE), labels=predictor.labels)
            for frame in pf.open_dataset(kitchen, calibration=calibration).frames("100:160:20"):
                mapper.add(frame, predictor.predict(frame))
            mapper.finish()
            self.assertEqual((mapper.frames["labelled"], mapper.map_hash()), (3, expected["map_hash"]))

    def test_arrays_and_frames_make_the_same_map(self):
        predictor = pf.file_predictor(home() / "predictions")
        mapper = pf.Mapper(pf.Options(**COARSE), labels=predictor.labels)
        for frame in pf.open_dataset(home()):
            seen = predictor.predict(frame)
            outcome = mapper.add(depth=frame.depth, color=frame.color, K=frame.depth_camera, pose=frame.pose, index=frame.index,
                                 color_K=frame.color_camera, color_from_depth=frame.color_from_depth, time_s=frame.time_s,
                                 segments=(seen.ids, seen.segments))
            self.assertTrue(outcome, outcome)
        mapper.finish()
        self.assertEqual(mapper.map_hash(), mapped().map_hash())

    def test_depth_in_millimetres_is_depth_in_metres(self):
        metres, millimetres = small_mapper(), small_mapper()
        given = arrays()
        metres.add(**given)
        millimetres.add(**(given | dict(depth=np.full((120, 160), 2000, np.uint16), depth_scale=1000)))
        self.assertEqual(metres.map_hash(), millimetres.map_hash())

    def test_segments_in_three_forms_make_the_same_map(self):
        ids = ids_of()
        masks = np.stack([ids == 1, ids == 2])
        panoptic = np.where(ids == 1, 1000, 3001).astype(np.int32)
        forms = [(ids, ["wall", "chair"]), (masks, ["wall", "chair"]), panoptic,
                 (np.where(ids == 2, 77, 5), [{"id": 5, "class": "wall"}, {"id": 77, "class": 3, "score": 1.0}]),
                 pf.Segmentation(ids, ["wall", "chair"], labels=LABELS)]
        hashes = set()
        for form in forms:
            mapper = small_mapper()
            for i in range(4):
                self.assertTrue(mapper.add(segments=form, **arrays(i)))
            self.assertEqual(mapper.frames["labelled"], 4)
            hashes.add(mapper.map_hash())
        self.assertEqual(len(hashes), 1)
        unlabelled = small_mapper()
        for i in range(4):
            unlabelled.add(**arrays(i))
        self.assertNotIn(unlabelled.map_hash(), hashes)

    def test_saved_and_loaded_is_the_same_map(self):
        path = scratch() / "room.panoptic"
        mapped().save(path)
        loaded = pf.load_map(path)
        self.assertEqual(loaded.hash(), mapped().map_hash())
        self.assertEqual([o.id for o in loaded.objects()], [o.id for o in mapped().map.objects()])
        self.assertEqual(loaded.options["map.voxel_size_m"], 0.05)
        self.assertEqual(len(loaded.frames), mapped().frames["used"])


class CorrectedPoses(unittest.TestCase):
    def drifting(self, **map_options):
        """A mapper of the home whose tracker drifts by 4 cm a frame, and the true poses."""
        mapper = pf.Mapper(pf.Options(map=COARSE["map"] | map_options), labels=mapped().labels)
        true_poses = {}
        for n, frame in enumerate(pf.open_dataset(home())):
            true_poses[frame.index] = frame.pose
            pose = frame.pose.copy()
            pose[0, 3] += 0.04 * n
            mapper.add(depth=frame.depth, color=frame.color, K=frame.depth_camera, color_K=frame.color_camera, pose=pose,
                       color_from_depth=frame.color_from_depth, index=frame.index, time_s=frame.time_s)
        return mapper, true_poses

    def test_the_map_is_that_of_the_corrected_poses(self):
        mapper, true_poses = self.drifting(log="reference")
        frames = {frame.index: frame for frame in pf.open_dataset(home())}
        wrong = mapper.map_hash()
        done = mapper.update_poses(true_poses | {10_000: np.eye(4)}, frames.__getitem__)
        self.assertEqual((done["frames"], done["unknown"]), (len(frames) - 1, 1))
        self.assertEqual(done["pause_ms"], done["ms"])
        copied, _ = self.drifting(log="copy")
        copied.update_poses(true_poses)
        self.assertEqual(copied.map_hash(), mapper.map_hash())
        right = pf.Mapper(pf.Options(**COARSE), labels=mapped().labels)
        for frame in frames.values():
            right.add(frame)
        self.assertNotEqual(right.map_hash(), wrong)
        self.assertEqual(mapper.map_hash(), right.map_hash())
        np.testing.assert_allclose(mapper.trajectory()[1][-1], frame.pose)

    def test_what_cannot_be_done_leaves_the_map_as_it_was(self):
        mapper, true_poses = self.drifting(log="reference")
        before = mapper.map_hash()
        with self.assertRaisesRegex(pf.Error, "cannot be read again: KeyError"):
            mapper.update_poses(true_poses, {}.__getitem__)
        with self.assertRaisesRegex(pf.Error, "must return a Frame"):
            mapper.update_poses(true_poses, lambda index: None)
        with self.assertRaisesRegex(pf.Error, "pose"):
            mapper.update_poses({0: np.full((4, 4), np.nan)}, {}.__getitem__)
        with self.assertRaisesRegex(pf.Error, "the log has no copy of it"):
            mapper.update_poses(true_poses)
        self.assertEqual(mapper.map_hash(), before)
        with self.assertRaisesRegex(pf.Error, "map.log = auto"):
            self.drifting()[0].update_poses(true_poses, {}.__getitem__)


class Views(unittest.TestCase):
    def test_a_mesh_is_seen_not_copied(self):
        mesh = mapped().mesh()
        self.assertEqual(mesh.vertices.shape, (len(mesh.class_id), 3))
        self.assertEqual((mesh.vertices.dtype, mesh.colors.dtype, mesh.triangles.dtype), (np.float32, np.uint8, np.uint32))
        self.assertEqual((mesh.class_id.dtype, mesh.panoptic_id.dtype), (np.uint16, np.uint32))
        self.assertEqual(address(mesh.vertices), address(mesh.vertices), "twice the same memory")
        self.assertLess(address(mesh.colors) - address(mesh.vertices), mesh.vertices.strides[0], "side by side in one vertex")
        self.assertLess(mesh.triangles.max(), len(mesh.vertices))
        with self.assertRaises(ValueError):
            mesh.triangles[0, 0] = 7

    def test_a_view_keeps_its_mesh(self):
        mesh = mapped().mesh()
        vertices = mesh.vertices
        expected = vertices.copy()
        del mesh
        gc.collect()
        np.testing.assert_array_equal(vertices, expected)

    def test_what_is_handed_over_is_read_where_it_lies(self):
        given = arrays()
        frame = pf.Frame(**given)
        self.assertEqual(address(frame.depth), address(given["depth"]))
        self.assertEqual(address(frame.color), address(given["color"]))
        part = np.full((120, 200), 2, np.float32)[:, 20:180]
        frame = pf.Frame(**(given | dict(depth=part)))
        self.assertEqual((address(frame.depth), frame.depth.strides), (address(part), part.strides))
        del part, given
        gc.collect()
        self.assertTrue((frame.depth == 2).all(), "the frame keeps the memory that it reads")

    def test_a_frame_is_seen_not_copied(self):
        frame = pf.open_dataset(home())[0]
        self.assertEqual(address(frame.depth), address(frame.depth))
        self.assertEqual((frame.depth.shape, frame.color.shape), ((480, 640), (480, 640, 3)))
        self.assertFalse(frame.color.flags.writeable)


class Blocks(unittest.TestCase):
    def test_voxels_are_where_the_map_says(self):
        chosen = max(mapped().map.blocks(), key=lambda b: (b.weight > 0).sum())
        distance, weight = chosen.distance, chosen.weight
        self.assertEqual(distance.shape, (16, 16, 16))
        x, y, z = (int(n) for n in np.argwhere(weight > 0)[-1])
        center = chosen.origin_m + (np.array([x, y, z]) + 0.5) * mapped().map.voxel_size_m
        answer = mapped().map.at(center)
        self.assertEqual(answer.weight, weight[x, y, z])
        self.assertEqual(answer.class_id, chosen.class_id[x, y, z])
        self.assertEqual(answer.panoptic_id, chosen.panoptic_id[x, y, z])

    def test_nothing_is_known_where_nothing_was_seen(self):
        self.assertIsNone(mapped().map.at([1000, 1000, 1000]))


@release_only("times mean nothing elsewhere")
class Cost(unittest.TestCase):
    """CPU time of this thread alone, the least of many, because other programs run too."""

    def least_ms(self, work):
        times = []
        for _ in range(60):
            begin = time.thread_time_ns()
            work()
            times.append(time.thread_time_ns() - begin)
        return min(times) / 1e6

    def test_a_frame_of_arrays_costs_a_fifth_of_a_millisecond_more(self):
        mapper = small_mapper()  # which has nothing to do: no frame has a reading
        given = arrays(width=640, height=480) | dict(K=np.array([[500.0, 0, 319.5], [0, 500.0, 239.5], [0, 0, 1]]))
        given["depth"][:] = 0
        rows, columns = np.mgrid[:480, :640]
        ids = (1 + rows // 60 * 8 + (columns + rows % 60) // 90).astype(np.uint16)  # 64 parallelograms
        segments = ["chair"] * int(ids.max())
        frame, seen = pf.Frame(**given), pf.Segmentation(ids, segments, labels=LABELS)
        least = self.least_ms(lambda: mapper.add(frame, seen))
        self.assertLess(self.least_ms(lambda: mapper.add(segments=(ids, segments), **given)) - least, 0.6)  # .12 on a core that nobody shares
        panoptic = 3000 + ids.astype(np.int32)
        self.assertLess(self.least_ms(lambda: mapper.add(segments=panoptic, **given)) - least, 0.35)
        raw = np.zeros((480, 640), np.uint16)
        self.assertLess(self.least_ms(lambda: mapper.add(segments=seen, **(given | dict(depth=raw, depth_scale=1000)))) - least, 0.3)


@release_only("a sanitizer keeps freed memory")
class Memory(unittest.TestCase):
    def test_frames_take_no_memory(self):
        frames = int(os.environ.get("PANOPTIC_FRAMES", 1000))
        mapper = small_mapper(regularizer={"enabled": False})
        given, segments = arrays(width=64, height=48), (ids_of(16, 64, 48), ["wall", "chair"])
        given["K"] = np.array([[40.0, 0, 31.5], [0, 40.0, 23.5], [0, 0, 1]])

        def resident_kb_after(count):
            for _ in range(count):
                mapper.add(segments=segments, **given)
            gc.collect()
            return int(pathlib.Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize() // 1024

        before = resident_kb_after(200)
        growth_kb = resident_kb_after(frames) - before
        self.assertLess(growth_kb, 3000)
        if "PANOPTIC_FRAMES" in os.environ:
            print(f"{frames} frames: {before} kB before, {growth_kb} kB more")


class Threads(unittest.TestCase):
    def test_python_runs_while_a_frame_is_mapped(self):
        counted = []
        done = threading.Event()

        def count():
            while not done.is_set():
                counted.append(time.perf_counter())
                time.sleep(0.0002)

        mapper = pf.Mapper(pf.Options(map={"voxel_size_m": 0.02}), labels="indoor")
        frame = pf.open_dataset(home())[0]
        thread = threading.Thread(target=count)
        thread.start()
        begin = time.perf_counter()
        for _ in range(10):
            mapper.add(frame)
        end = time.perf_counter()
        done.set()
        thread.join()
        self.assertGreater(sum(begin < t < end for t in counted), 5)


if __name__ == "__main__":
    unittest.main()
