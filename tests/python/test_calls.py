# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Wrong calls that newcomers make have answers of one line."""
import unittest

import numpy as np

import panoptic as pf
from home import arrays, mapped, small_mapper


class Calls(unittest.TestCase):
    def refusal(self, call, *arguments, **named):
        with self.assertRaises(pf.Error) as caught:
            call(*arguments, **named)
        message = str(caught.exception)
        self.assertNotIn("\n", message)
        return message

    def test_frames_that_are_given_in_a_wrong_way(self):
        mapper, a = small_mapper(), arrays()
        self.assertIn("by name", self.refusal(mapper.add, a["depth"], a["color"], a["K"], a["pose"]))
        self.assertIn("no argument 'colour'", self.refusal(mapper.add, depth=a["depth"], colour=a["color"], K=a["K"], pose=a["pose"]))
        self.assertIn("whole number", self.refusal(mapper.add, **(a | {"index": "a"})))
        self.assertIn("time_s is 'x': it must be a number", self.refusal(mapper.add, **(a | {"time_s": "x"})))
        pipeline = pf.OnlinePipeline(mapper)
        self.assertIn("by name", self.refusal(pipeline.push, a["depth"], a["color"], a["K"], a["pose"]))
        pipeline.finish()

    def test_frames_without_an_index_are_counted(self):
        mapper = small_mapper()
        for index, expected in [(None, 0), (None, 1), (7, 7), (None, 8)]:
            mapper.add(**(arrays() | {"index": index, "depth": np.zeros((120, 160), np.float32)}))
            self.assertEqual(mapper.frames["first_skipped"][-1][0], expected)

    def test_a_predictor_with_other_classes(self):
        class Other(pf.Predictor):
            def predict(self, frame):
                return None

        other = Other(pf.LabelSet("other", [pf.LabelClass(1, "robot")]))
        self.assertIn("labels=predictor.labels", self.refusal(pf.OnlinePipeline, small_mapper(), other))

    def test_groups_of_options_are_dicts(self):
        self.assertIn("'map' is a group", self.refusal(pf.Options, map=0.05))

    def test_objects_stand_for_their_ids(self):
        room = mapped().map
        one = room.objects()[0]
        self.assertEqual(room.explain(one)["id"], one.id)
        self.assertIn("is no object", self.refusal(room.explain, "chair_3"))


if __name__ == "__main__":
    unittest.main()
