# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Networks that are written in Python, frame by frame and online."""
import threading
import time
import unittest

import numpy as np

import panoptic as pf
from home import LABELS, arrays, home, ids_of, mapped, small_mapper


class Wall(pf.Predictor):
    """Sees a chair in front of a wall, and remembers who asked."""

    def __init__(self, answer=None):
        super().__init__(LABELS)
        self.answer = answer or (lambda frame: pf.Segmentation(ids_of(), ["wall", "chair"], labels=self.labels))
        self.threads = set()
        self.seen = []

    def predict(self, frame):
        self.threads.add(threading.get_ident())
        self.seen.append(frame)
        return self.answer(frame)


class Offline(unittest.TestCase):
    def test_a_predictor_in_python_labels_the_map(self):
        mapper, predictor = small_mapper(), Wall()
        for i in range(12):
            frame = pf.Frame(**arrays(i))
            mapper.add(frame, predictor.predict(frame))
        mapper.finish()
        self.assertEqual([o.class_name for o in mapper.map.objects("chair")], ["chair"])
        self.assertEqual(mapper.segment_ids()[0], LABELS.id_of("wall"))

    def test_masks_and_the_rest_make_one_image(self):
        small, large = np.zeros((2, 6, 8), bool)
        small[1:3, 1:3] = True
        large[0:5, 0:5] = True
        semantic = np.full((6, 8), LABELS.id_of("floor"))
        seen = pf.Segmentation.from_masks(np.stack([large, small]), ["chair", "cup"], LABELS, scores=[0.9, 0.6], semantic=semantic)
        classes = np.array([0] + [s.class_id for s in seen.segments])[seen.ids]
        self.assertEqual(classes[2, 2], LABELS.id_of("cup"), "the smaller one is in front")
        self.assertEqual(classes[4, 4], LABELS.id_of("chair"))
        self.assertEqual(classes[5, 7], LABELS.id_of("floor"))
        self.assertEqual(sorted(round(s.score, 3) for s in seen.segments), [0.6, 0.9, 1.0])


class Numbers(unittest.TestCase):
    """Id images of any type and layout mean what NumPy's look-up says."""

    IDS = [1, 2, 17, 100]  # of four segments, as far as a type holds them

    def expected(self, ids):
        seen = np.zeros(ids.shape, np.uint16)
        for place, number in enumerate(self.IDS):
            seen[ids == number] = place + 1
        return seen

    def segmentation(self, ids, numbers):
        return pf.Segmentation(ids, [{"class": 3, "id": int(n)} for n in numbers])

    def test_ids_of_every_type_and_layout_are_looked_up(self):
        random = np.random.default_rng(5)
        for width in (1, 15, 16, 37, 64):
            rough = random.choice([0, *self.IDS], (9, width))
            smooth = np.repeat(rough[:, ::8], 8, axis=1)[:, :width]
            for ids in (rough, smooth):
                for kind in ("i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", ">i2", ">u4", ">i8"):
                    image = ids.astype(kind)
                    layouts = [image, np.asfortranarray(image), image[::-1, ::-1], np.repeat(image, 3, axis=1)[:, ::3],
                               np.broadcast_to(image[:1], image.shape)]
                    for given in layouts:
                        seen = self.segmentation(given, self.IDS)
                        np.testing.assert_array_equal(seen.ids, self.expected(given), f"{kind} {width} {given.strides}")

    def test_numbers_far_apart_are_told_apart(self):
        numbers = [-1, -(1 << 40), 5, 5 + 1024, 5 + 1024 * 7, 1024, 2048, (1 << 62) + 5]
        ids = np.array(numbers * 5 + [0], np.int64)[None, :].repeat(3, axis=0)
        seen = self.segmentation(ids, numbers)
        np.testing.assert_array_equal(seen.ids[0], [1, 2, 3, 4, 5, 6, 7, 8] * 5 + [0])
        for stranger in (6, 5 + 512, -2, 1 << 50):
            ids[2, -1] = stranger
            with self.assertRaisesRegex(pf.Error, f"ids holds {stranger}, and no segment"):
                self.segmentation(ids, numbers)

    def test_masks_are_what_their_pixels_say(self):
        random = np.random.default_rng(6)
        for _ in range(20):
            masks = random.random((3, 11, 37)) < random.choice([0.03, 0.5])
            masks[:, random.integers(11), random.integers(37)] = True
            given = masks if random.random() < 0.5 else np.asfortranarray(masks.astype(np.uint8) * 7)
            seen = pf.Segmentation.from_masks(given, ["chair", "cup", "wall"], LABELS)
            expected = np.zeros((11, 37), int)
            expected[masks[2]] = LABELS.id_of("wall")
            order = sorted((0, 1), key=lambda i: masks[i].sum(), reverse=True)  # the smaller is in front; of two as large, the first
            for i in order if masks[0].sum() != masks[1].sum() else (1, 0):
                expected[masks[i]] = (3, 4)[i]
            np.testing.assert_array_equal(np.array([0] + [s.class_id for s in seen.segments])[seen.ids], expected)


class Online(unittest.TestCase):
    def run_online(self, predictor, count=40):
        mapper = small_mapper(online={"mesh_every_s": 0.05})
        pipeline = pf.OnlinePipeline(mapper, predictor)
        for i in range(count):
            self.assertTrue(pipeline.push_when_free(**arrays(i)))
        return mapper, pipeline

    def test_a_predictor_in_python_labels_the_map_from_another_thread(self):
        predictor = Wall()
        mapper, pipeline = self.run_online(predictor)
        report = pipeline.finish()
        self.assertEqual(report["read"], 40)
        self.assertEqual(report["used"] + report["skipped"] + report["dropped"] + report["lost"], 40)
        self.assertGreater(report["labelled"], 0)
        self.assertNotIn(threading.get_ident(), predictor.threads)
        self.assertTrue(mapper.finished)
        self.assertGreater(len(mapper.mesh().vertices), 0)
        self.assertEqual(predictor.seen[0].depth.shape, (120, 160), "a frame that was seen may be kept")
        self.assertEqual(pipeline.finish(), report)

    def test_a_snapshot_stays_as_it_is(self):
        mapper, pipeline = self.run_online(Wall())
        until = time.monotonic() + 20
        while pipeline.snapshot().revision == 0 and time.monotonic() < until:
            time.sleep(0.01)
        snapshot = pipeline.snapshot()
        vertices = snapshot.mesh.vertices
        before = vertices.copy()
        pipeline.finish()
        last = pipeline.snapshot()
        self.assertTrue(last.finished)
        self.assertGreater(last.revision, snapshot.revision)
        self.assertEqual(last.frame, 39)
        np.testing.assert_array_equal(vertices, before)
        self.assertEqual({o["class_name"] for o in last.objects if o["class_name"] == "chair"}, {"chair"})
        self.assertLess(last.mesh.triangles.max(), len(last.mesh.vertices))
        self.assertEqual(last.path.shape[1], 3)

    def test_memory_that_was_pushed_may_be_used_again(self):
        changed, kept = small_mapper(), small_mapper()
        pipeline = pf.OnlinePipeline(changed)
        given = arrays()
        for _ in range(5):
            pipeline.push_when_free(**given)
            given["depth"][:] = 3
            given = arrays()
        pipeline.finish()
        pipeline = pf.OnlinePipeline(kept)
        for _ in range(5):
            pipeline.push_when_free(**arrays())
        pipeline.finish()
        self.assertEqual(changed.map_hash(), kept.map_hash())

    def test_what_a_predictor_raises_reaches_the_caller(self):
        def fail(frame):
            raise KeyError("no weights")

        mapper, pipeline = self.run_online(Wall(fail), count=1)
        with self.assertRaisesRegex(pf.Error, "the predictor raised KeyError: 'no weights'") as caught:
            pipeline.finish()
        self.assertIsInstance(caught.exception.__cause__, KeyError)
        self.assertIsNotNone(caught.exception.__cause__.__traceback__)
        with self.assertRaises(pf.Error):
            pipeline.push(**arrays())
        self.assertLessEqual(mapper.frames["used"], 1, "the map holds what was fused by then")

    def test_an_answer_that_is_none_of_ours_is_refused(self):
        wrong = {"panoptic image": lambda f: "chair", "differ in size": lambda f: (np.ones((3, 3), int), [1]),
                 "no class with the number 9": lambda f: pf.Segmentation(ids_of(), [pf.Segment(9), pf.Segment(9)])}
        for message, answer in wrong.items():
            _, pipeline = self.run_online(Wall(answer), count=1)
            with self.assertRaisesRegex(pf.Error, message):
                pipeline.finish()

    def test_a_frame_without_a_prediction_is_mapped(self):
        mapper, pipeline = self.run_online(Wall(lambda frame: None), count=5)
        self.assertEqual(pipeline.finish()["labelled"], 0)
        self.assertEqual(mapper.frames["used"], 5)

    def test_a_pipeline_that_is_forgotten_ends(self):
        mapper, pipeline = self.run_online(Wall(), count=3)
        del pipeline
        self.assertTrue(mapper.finished)
        self.assertEqual(len(mapper.map_hash()), 16)

    def test_frames_that_come_too_fast_are_dropped_and_counted(self):
        mapper = pf.Mapper(pf.Options(map={"voxel_size_m": 0.01}, online={"waiting_frames": 1}), labels=LABELS)
        pipeline = pf.OnlinePipeline(mapper)
        taken = sum(pipeline.push(**arrays(i)) for i in range(60))
        report = pipeline.finish()
        self.assertEqual(report["dropped"], 60 - taken)
        self.assertEqual(report["used"], taken)
        self.assertGreater(report["dropped"], 0)


class FromFiles(unittest.TestCase):
    def test_predictions_know_their_labels_and_frames(self):
        predictor = pf.file_predictor(home() / "predictions")
        seen = predictor.predict(pf.open_dataset(home())[3])
        self.assertTrue(seen)
        self.assertEqual(seen.ids.shape, (480, 640))
        self.assertEqual(len(predictor.labels), len(mapped().labels))

    def test_options_that_name_nothing_make_none(self):
        self.assertIsNone(pf.make_predictor(pf.Options()))
        self.assertIsNotNone(pf.make_predictor(pf.Options(predictions=home() / "predictions")))


if __name__ == "__main__":
    unittest.main()
