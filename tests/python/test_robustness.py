# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Whatever Python hands over, the answer is a result or an exception that says what is wrong; never a crash."""
import gc
import pathlib
import threading
import unittest

import numpy as np

import panoptic as pf
from home import K, LABELS, arrays, home, ids_of, small_mapper


def turned(**changes):
    return arrays() | changes


class WrongArrays(unittest.TestCase):
    def refused(self, pattern, mapper=None, segments=None, **changes):
        mapper = mapper or small_mapper()
        with self.assertRaisesRegex(pf.Error, pattern) as caught:
            mapper.add(segments=segments, **turned(**changes))
        self.assertNotIn("\n", str(caught.exception))
        self.assertEqual(mapper.frames["used"], 0, "nothing was added")

    def test_depth_of_another_type_is_refused(self):
        depth = arrays()["depth"]
        self.refused("float64.*must be float32", depth=depth.astype(np.float64))
        self.refused("int32.*must be float32", depth=depth.astype(np.int32))
        self.refused("float16.*must be float32", depth=depth.astype(np.float16))
        self.refused(">f4.*must be float32", depth=depth.astype(">f4"))
        self.refused("object.*must be float32", depth=depth.astype(object))
        self.refused("depth_scale=1000", depth=depth.astype(np.uint16))
        for scale in (0.0, -1.0, float("nan"), float("inf")):
            self.refused("depth_scale=1000", depth=depth.astype(np.uint16), depth_scale=scale)
        self.refused("leave out depth_scale", depth_scale=1000)

    def test_images_of_another_shape_are_refused(self):
        depth, color = arrays()["depth"], arrays()["color"]
        self.refused("depth is .*must be .height, width", depth=depth[None])
        self.refused("depth has no pixels", depth=depth[:0])
        self.refused("color is .*uint8 of shape", color=color[..., 0])
        self.refused("color is .*uint8 of shape", color=color[..., :2])
        self.refused("color is float32", color=color.astype(np.float32))
        self.refused("color has 80x120 pixels.*color_K", color=np.ascontiguousarray(color[:, :80]))
        self.refused("color has no pixels", color=color[:, :0])
        self.refused("at most 32768", depth=np.zeros((1, 40000), np.float32))

    def test_strides_that_cannot_be_read_are_refused(self):
        depth, color = arrays()["depth"], arrays()["color"]
        self.refused("ascontiguousarray.color", color=color[..., ::-1])
        self.refused("ascontiguousarray.color", color=np.asfortranarray(color))
        self.refused("ascontiguousarray.depth", depth=np.asfortranarray(depth))
        self.refused("ascontiguousarray.depth", depth=np.zeros((120, 320), np.float32)[:, ::2])
        self.refused("ascontiguousarray.depth", depth=np.broadcast_to(np.float32(2), (120, 160)))

    def test_an_image_whose_last_row_comes_first_is_read(self):
        upright, given = small_mapper(), arrays()
        given["depth"][:40] = 1
        given["color"][:, :, 1] = np.arange(120, dtype=np.uint8)[:, None]
        upright.add(**given)
        flipped = {name: np.ascontiguousarray(given[name][::-1])[::-1] for name in ("depth", "color")}
        self.assertLess(flipped["depth"].strides[0], 0)
        mapper, online = small_mapper(), small_mapper()
        mapper.add(**(given | flipped))
        pipeline = pf.OnlinePipeline(online)
        pipeline.push_when_free(**(given | flipped))
        del flipped
        pipeline.finish()
        self.assertEqual(mapper.map_hash(), upright.map_hash())
        upright.finish()
        self.assertEqual(online.map_hash(), upright.map_hash())

    def test_memory_that_is_not_aligned_is_read_or_refused(self):
        raw = np.zeros(120 * 160 * 4 + 1, np.uint8)
        depth = raw[1:].view(np.float32).reshape(120, 160)
        depth[:] = 2
        try:
            self.assertTrue(small_mapper().add(**turned(depth=depth)))
        except pf.Error as error:
            self.assertIn("copy", str(error))

    def test_rows_of_a_wider_image_are_read(self):
        wide = np.full((120, 200), 2, np.float32)
        whole, part = small_mapper(), small_mapper()
        whole.add(**arrays())
        part.add(**turned(depth=wide[:, 20:180]))
        self.assertEqual(whole.map_hash(), part.map_hash())

    def test_a_pose_that_is_none_is_refused(self):
        pose = np.eye(4)
        for value in (np.nan, np.inf):
            wrong = pose.copy()
            wrong[1, 3] = value
            self.refused("pose is not finite", pose=wrong)
        self.refused("transposed", pose=np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [1, 2, 3, 1]]))
        self.refused("not a rigid transform", pose=2 * pose - np.diag([0, 0, 0, 1]))
        self.refused("not a rigid transform", pose=np.diag([1.0, 1, -1, 1]))
        self.refused("4x4", pose=np.eye(3))
        self.refused("numbers", pose=np.full((4, 4), "a"))
        self.refused("no array|numbers", pose=[[1, 2], [3]])
        self.refused("pose is missing", pose=None)

    def test_a_camera_that_is_none_is_refused(self):
        self.refused("3x3", K=np.eye(4))
        self.refused("transposed", K=K.T)
        self.refused("above zero", K=K * np.array([[-1], [1], [1]]))
        self.refused("above zero|must be", K=np.full((3, 3), np.nan))
        self.refused("64x48", K=pf.Camera(64, 48, 40, 40, 31.5, 23.5))

    def test_segments_that_fit_nothing_are_refused(self):
        ids = ids_of()
        self.refused("no segment has", segments=(ids, ["wall"]))
        self.refused("no class 'sofa'", segments=(ids, ["wall", "sofa"]))
        self.refused("no class with the number 9", segments=(ids, [1, 9]))
        self.refused("no class with the number 0", segments=(ids, [0, 1]))
        self.refused("is no class", segments=(ids, [1, None]))
        self.refused("differ in size", segments=(ids[:60], ["wall", "chair"]))
        self.refused("whole numbers", segments=(ids.astype(np.float32), ["wall", "chair"]))
        self.refused("no segment has", segments=(np.full(ids.shape, -5), ["wall"]))
        self.refused("from 0 to 1", segments=(ids, [{"class": 1}, {"class": 3, "score": float("nan")}]))
        self.refused("from 0 to 1", segments=(ids, [{"class": 1}, {"class": 3, "score": 2}]))
        for number in (1.5, "2", None, 1 << 70):
            self.refused("whole number of 64 bits", segments=(ids, [{"class": 1, "id": 1}, {"class": 3, "id": number}]))
        self.refused("add up to 1.1", segments=(ids, [1, {"class": 3, "probabilities": {"chair": 0.5, "cup": 0.6}}]))
        self.refused("the key 'clas'", segments=(ids, [{"clas": 1}, 3]))
        self.refused("two segments", segments=(ids, [{"class": 1, "id": 1}, {"class": 3, "id": 1}]))
        self.refused("some have none", segments=(ids, [{"class": 1, "id": 1}, 3]))
        self.refused("no class with the number 9", segments=(ids, [pf.Segment(9), pf.Segment(1)]))
        self.refused("panoptic image", segments="chair")
        self.refused("no class with the number 50", segments=np.full(ids.shape, 50001, np.int64))
        self.refused("no class", segments=np.full(ids.shape, -1, np.int64))

    def test_masks_that_fit_nothing_are_refused(self):
        mask = np.ones((1, 120, 160), bool)
        self.refused("mask 0 has no pixel", segments=(np.zeros_like(mask), ["chair"]))
        self.refused("1 masks and 2 classes", segments=(mask, ["chair", "wall"]))
        self.refused("1 masks and 0 scores", segments=(mask, ["chair"], []))
        self.refused("bool or uint8", segments=(mask.astype(np.float32), ["chair"]))
        self.refused("from 0 to 1", segments=(mask, ["chair"], [float("nan")]))
        self.refused("differ in size", segments=(mask[:, :60], ["chair"]))

    def test_a_frame_in_which_nothing_was_found_is_a_prediction(self):
        mapper = small_mapper()
        self.assertTrue(mapper.add(segments=(np.zeros((0, 120, 160), bool), []), **arrays()))
        self.assertEqual(mapper.frames["labelled"], 1)

    def test_a_frame_without_a_reading_is_counted(self):
        mapper = small_mapper()
        outcome = mapper.add(**turned(depth=np.zeros((120, 160), np.float32)))
        self.assertFalse(outcome)
        self.assertIn("no reading", outcome.reason)
        self.assertEqual(mapper.frames["skipped"], 1)
        self.assertEqual(mapper.frames["first_skipped"], [(0, outcome.reason)])

    def test_any_depth_is_survived(self):
        mapper = small_mapper()
        for value in (np.nan, np.inf, -np.inf, -1, 1e30, 1e-30):
            depth = arrays()["depth"]
            depth[::2] = value
            mapper.add(**turned(depth=depth))
        self.assertEqual(len(mapper.map_hash()), 16)

    def test_a_frame_and_arrays_at_once_are_refused(self):
        mapper = small_mapper()
        with self.assertRaisesRegex(pf.Error, "not both"):
            mapper.add(pf.Frame(**arrays()), **arrays())
        with self.assertRaisesRegex(pf.Error, "must be a Frame"):
            mapper.add(arrays()["depth"])


class Lifetimes(unittest.TestCase):
    def test_nothing_is_added_after_finish(self):
        mapper = small_mapper()
        mapper.add(**arrays())
        mapper.finish()
        for use in (lambda: mapper.add(**arrays()), mapper.finish, mapper.regularize, lambda: mapper.skip(1, "lost"),
                    lambda: pf.OnlinePipeline(mapper)):
            with self.assertRaisesRegex(pf.Error, "finished"):
                use()
        self.assertGreater(len(mapper.mesh().vertices), 0, "but it can be read")

    def test_an_empty_mapper_can_be_read(self):
        mapper = small_mapper()
        mapper.finish()
        self.assertEqual(mapper.mesh().vertices.shape, (0, 3))
        self.assertEqual(mapper.mesh().triangles.shape, (0, 3))
        self.assertEqual((mapper.map.objects(), mapper.map.blocks()), ([], []))

    def test_parts_outlive_what_they_are_of(self):
        mapper = small_mapper()
        mapper.add(segments=(ids_of(), ["wall", "chair"]), **arrays())
        view, blocks, mesh = mapper.map, mapper.map.blocks(), mapper.mesh()
        vertices, distance = mesh.vertices, blocks[0].distance
        del mapper, mesh
        gc.collect()
        self.assertEqual(len(view.hash()), 16)
        self.assertEqual(blocks[-1].weight.shape, (16, 16, 16))
        self.assertTrue(np.isfinite(vertices).all() and np.isfinite(distance).all())

    def test_objects_that_were_never_made_are_refused(self):
        for name in pf.__all__:
            kind = getattr(pf, name)
            if not isinstance(kind, type) or kind is pf.Error:
                continue
            unmade = kind.__new__(kind)
            for part in vars(kind):
                if part.startswith("__") and part not in ("__len__", "__bool__", "__repr__") or isinstance(vars(kind)[part], staticmethod):
                    continue
                with self.assertRaises((pf.Error, TypeError, RuntimeError), msg=f"{name}.{part}"):
                    value = getattr(unmade, part)
                    value()
        with self.assertRaisesRegex(pf.Error, "was not made: __init__ of its class was never called"):
            pf.Camera.__new__(pf.Camera).width

    def test_ctrl_c_in_what_an_array_does_is_kept(self):
        class Array:
            def __array__(self, *_, **__):
                raise KeyboardInterrupt

        with self.assertRaises(KeyboardInterrupt):
            small_mapper().add(**turned(depth=Array()))

    def test_a_predictor_that_was_not_made_is_refused(self):
        class Careless(pf.Predictor):
            def __init__(self):
                pass

        with self.assertRaises(TypeError):
            Careless()
        with self.assertRaisesRegex(pf.Error, "predict"):
            pf.Predictor("indoor").predict(pf.Frame(**arrays()))
        with self.assertRaisesRegex(pf.Error, "Predictor or None"):
            pf.OnlinePipeline(small_mapper(), 3)


class TwoThreads(unittest.TestCase):
    def test_one_mapper_in_two_threads_is_refused_or_waits_its_turn(self):
        mapper = pf.Mapper(pf.Options(map={"voxel_size_m": 0.01}), labels=LABELS)
        frames = [pf.Frame(**arrays(i)) for i in range(3)]
        messages, others, used = set(), [], []

        def add():
            for _ in range(4):
                for frame in frames:
                    try:
                        used.append(bool(mapper.add(frame, (ids_of(), ["wall", "chair"]))))
                        mapper.mesh()
                        mapper.map.objects()
                        mapper.map_hash()
                    except pf.Error as error:
                        messages.add(str(error))
                    except BaseException as error:  # of any kind, to be told below
                        others.append(error)

        threads = [threading.Thread(target=add) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(others, [])
        self.assertEqual(len(messages), 1, messages)
        self.assertIn("one thread at a time", messages.pop())
        self.assertEqual(mapper.frames["used"], len(used))

    def test_one_predictor_in_two_threads_is_refused_or_waits_its_turn(self):
        predictor, frame = pf.file_predictor(home() / "predictions"), pf.open_dataset(home())[3]
        expected, seen, messages = predictor.predict(frame), [], set()

        def predict():
            for _ in range(5):
                try:
                    seen.append(predictor.predict(frame) == expected)
                except pf.Error as error:
                    messages.add(str(error))

        threads = [threading.Thread(target=predict) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertTrue(seen and all(seen))
        self.assertEqual({m.split(":")[0] for m in messages}, {"the predictor is in use by another call"})

    def test_a_predictor_belongs_to_its_pipeline(self):
        predictor = pf.file_predictor(home() / "predictions")
        mapper, other = (pf.Mapper(labels=predictor.labels) for _ in range(2))
        pipeline = pf.OnlinePipeline(mapper, predictor)
        for use in (lambda: pf.OnlinePipeline(other, predictor), lambda: predictor.predict(pf.Frame(**arrays()))):
            with self.assertRaisesRegex(pf.Error, "predictor is in use by an online pipeline"):
                use()
        pipeline.finish()
        self.assertEqual(len(other.map_hash()), 16, "which was given back")
        pf.OnlinePipeline(other, predictor).finish()

    def test_a_mapper_belongs_to_its_pipeline(self):
        mapper = small_mapper()
        pipeline = pf.OnlinePipeline(mapper)
        for use in (mapper.mesh, mapper.map_hash, lambda: mapper.add(**arrays()), lambda: mapper.map.objects(),
                    lambda: pf.OnlinePipeline(mapper)):
            with self.assertRaisesRegex(pf.Error, "in use by an online pipeline"):
                use()
        with self.assertRaisesRegex(pf.Error, "in progress"):
            pf.set_threads(1)
        pipeline.finish()
        self.assertEqual(len(mapper.map_hash()), 16)


class WrongNames(unittest.TestCase):
    def test_options_that_are_none_are_refused(self):
        for wrong, pattern in ((dict(map={"voxel_size": 0.1}), "unknown key.*voxel_size_m"), (dict(map={"voxel_size_m": "0.1"}), "a number"),
                               (dict(map={"voxel_size_m": float("nan")}), "between"), (dict(map={"voxel_size_m": -1}), "between"),
                               (dict(regularizer={"enabled": 1}), "true or false"), (dict(preset="papyrus"), "no preset"),
                               (dict(labels=object()), "no value"), (dict(nonsense=3), "unknown key")):
            with self.assertRaisesRegex(pf.Error, pattern) as caught:
                pf.Options(**wrong)
            self.assertNotIn("--set", str(caught.exception))
        with self.assertRaises(KeyError):
            pf.Options()["map.voxels"]
        within_itself, list_in_itself = {}, []
        within_itself["map"] = within_itself
        list_in_itself.append(list_in_itself)
        for wrong in (dict(map=within_itself), dict(networks={"semantic": list_in_itself})):
            with self.assertRaises(RecursionError):
                pf.Options(**wrong)
        for threads in (-1, 1025):
            with self.assertRaisesRegex(pf.Error, "1024"):
                pf.set_threads(threads)

    def test_a_name_that_is_no_text_is_told(self):
        with self.assertRaisesRegex(pf.Error, r"a\\xffb"):
            pf.open_dataset("a\udcffb")

    def test_files_that_are_none_are_refused(self):
        for use in (lambda: pf.load_map("nowhere.panoptic"), lambda: pf.open_dataset("nowhere"), lambda: pf.open_dataset("sim:x"),
                    lambda: pf.file_predictor("nowhere"), lambda: pf.read_ply("nowhere.ply"), lambda: pf.LabelSet("nowhere"),
                    lambda: pf.diff_maps("a", "b"), lambda: pf.merge_maps("a", "b", "c"), lambda: pf.evaluate("a", "b"),
                    lambda: pf.explain("nowhere", 3), lambda: pf.Options(file="nowhere.toml"), lambda: pf.load_map(__file__)):
            with self.assertRaises(pf.Error):
                use()

    def test_places_that_cannot_be_written_are_refused(self):
        mapper = small_mapper()
        mapper.add(**arrays())
        for use in (lambda p: mapper.save(p / "x"), lambda p: mapper.save_outputs(p / "x"), lambda p: mapper.mesh().save(p / "x.ply"),
                    lambda p: mapper.mesh().save(p / "x.glb"), lambda p: mapper.mesh().save("x.obj")):
            with self.assertRaisesRegex(pf.Error, "x") as caught:
                use(pathlib.Path(__file__))
            self.assertNotIn("\n", str(caught.exception))

    def test_places_that_are_none_are_refused(self):
        view = small_mapper().map
        for point in ([np.nan, 0, 0], [1, 2], "abc", None, [[1, 2, 3]]):
            with self.assertRaises(pf.Error):
                view.at(point)
        with self.assertRaisesRegex(pf.Error, "above max_m"):
            view.in_box([1, 0, 0], [0, 1, 1])
        with self.assertRaises(pf.Error):
            view.nearest([0, 0, 0], -1)
        with self.assertRaises(pf.Error):
            view.explain(-3)
        with self.assertRaises(IndexError):
            pf.open_dataset(home())[8]


if __name__ == "__main__":
    unittest.main()
