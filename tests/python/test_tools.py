# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Queries, scores, two maps, evidence, datasets, the stubs and the examples."""
import ast
import contextlib
import inspect
import io
import json
import os
import pathlib
import runpy
import signal
import subprocess
import sys
import threading
import unittest
import warnings
from unittest import mock

import numpy as np

import panoptic as pf
from home import LABELS, PROGRAM, SOURCE, arrays, home, ids_of, mapped, release_only, run_program, scratch, small_mapper

EXAMPLES = SOURCE / "examples/python"


def run_script(path, *arguments):
    """What the script prints."""
    printed = io.StringIO()
    with mock.patch.object(sys, "argv", [str(path), *map(str, arguments)]), contextlib.redirect_stdout(printed):
        runpy.run_path(str(path), run_name="__main__")
    return printed.getvalue()


class Queries(unittest.TestCase):
    def test_objects_are_found_by_class_box_and_place(self):
        objects = mapped().map.objects()
        things = [o for o in objects if mapped().labels.is_thing(o.class_id)]
        self.assertFalse(mapped().labels.is_thing(0), "which objects of no known class have")
        self.assertGreater(len(things), 0)
        thing = things[0]
        self.assertIn(thing.id, [o.id for o in mapped().map.objects(thing.class_name)])
        self.assertIn(thing.id, [o.id for o in mapped().map.objects(thing.class_id)])
        self.assertIn(thing.id, [o.id for o in mapped().map.in_box(thing.min_m, thing.max_m)])
        nearest, distance = mapped().map.nearest(thing.center_m, count=1)[0]
        self.assertLess(distance, 1)
        self.assertTrue((thing.min_m <= thing.center_m).all())
        self.assertIn(thing.class_name, repr(thing))
        with self.assertRaisesRegex(pf.Error, "there is no class|no class"):
            mapped().map.objects("submarine")

    def test_an_object_says_why_it_is_what_it_is(self):
        thing = next(o for o in mapped().map.objects() if o.observations > 2)
        why = mapped().map.explain(thing.id)
        self.assertEqual(why["class"], thing.class_name)
        self.assertEqual(sum(sum(s["classes"].values()) for s in why["votes"]), thing.observations)
        view = why["best_views"][0]
        frame = next(f for f in pf.open_dataset(home()) if f.index == view["frame"])
        picture = pf.crop(frame, view["box"], margin=0)
        u0, v0, u1, v1 = view["box"]
        np.testing.assert_array_equal(picture, frame.color[v0:v1, u0:u1])

    def test_a_run_on_disk_gives_crops(self):
        folder = scratch() / "outputs"
        mapped().save_outputs(folder, recording=str(home()), pictures=False)
        thing = next(o for o in mapped().map.objects() if o.observations > 2)
        crops = pf.evidence_crops(folder, thing.id)
        self.assertEqual([view["frame"] for view, _ in crops], [v["frame"] for v in mapped().map.explain(thing.id)["best_views"]])
        self.assertEqual(pf.explain(folder, thing.id)["class"], thing.class_name)
        self.assertEqual(json.loads((folder / "report.json").read_text())["map_hash"], mapped().map_hash())


class Pictures(unittest.TestCase):
    def test_shapes_hold_their_vertices(self):
        mesh = mapped().mesh()
        shapes = mesh.shapes()
        self.assertEqual([s["id"] for s in shapes], sorted(set(mesh.panoptic_id.tolist()) - {0}))
        for shape in shapes[:5]:
            vertices = mesh.vertices[mesh.panoptic_id == shape["id"]].astype(float)
            self.assertEqual(len(vertices), shape["vertices"])
            np.testing.assert_allclose(vertices.min(axis=0), shape["min_m"], atol=1e-6)
            box_from_world = np.linalg.inv(shape["world_from_box"])
            inside = abs(vertices @ box_from_world[:3, :3].T + box_from_world[:3, 3])
            self.assertTrue((inside <= shape["box_size_m"] / 2 + 1e-5).all())
        self.assertAlmostEqual(sum(mesh.class_areas_m2().values()), self.area_m2(mesh), places=3)

    def area_m2(self, mesh):
        a, b, c = (mesh.vertices[mesh.triangles[:, i]].astype(float) for i in range(3))
        return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2

    def test_a_mesh_is_drawn_from_three_sides(self):
        mapped().mesh().save_views(scratch() / "views", mapped().up)
        names = sorted(p.name for p in (scratch() / "views").iterdir())
        self.assertEqual(len(names), 9, names)
        with self.assertRaisesRegex(pf.Error, "up is"):
            mapped().mesh().save_views(scratch() / "views", [0, 0])
        with self.assertRaisesRegex(pf.Error, "direction"):
            mapped().mesh().save(scratch() / "views.glb", up=[0, 0, 0])


class Scores(unittest.TestCase):
    def test_a_map_scores_the_same_from_python_and_from_the_program(self):
        path = scratch() / "scored.panoptic"
        mapped().save(path)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            scores = pf.evaluate(pf.load_map(path), home())
        self.assertGreater(scores["miou"], 0)
        if PROGRAM:
            run_program("eval", path, "--gt", home(), "--json", scratch() / "scores.json")
            expected = json.loads((scratch() / "scores.json").read_text())
            self.assertEqual({k: scores[k] for k in ("miou", "ap50", "pq")}, {k: expected[k] for k in ("miou", "ap50", "pq")})


    def test_scenes_add_up_and_the_truth_agrees_with_itself(self):
        truth = pf.read_scan_truth(home())
        self.assertEqual((truth.positions.shape[1], truth.triangles.shape[1], truth.colors.shape), (3, 3, truth.positions.shape))
        self.assertLess(truth.triangles.max(), len(truth.positions))
        evaluation = pf.Evaluation()
        for _ in range(2):
            evaluation.add_labels(truth.class_id, truth.instance, truth)
        scores = evaluation.scores()
        self.assertEqual((scores["miou"], scores["pq"]["all"]), (1, 1))
        self.assertIn("2 scenes", evaluation.table())
        both, one = pf.Evaluation(), pf.evaluate(mapped().map, truth)
        for given in (truth, home()):
            both.add(mapped().map, given)
        self.assertEqual(both.scores()["miou"], one["miou"], "twice the same scene")
        self.assertLess(one["miou"], 1)
        for class_id, instance, message in ((truth.class_id[:-1], truth.instance[:-1], "vert"),
                                            (truth.class_id.astype(float), truth.instance, "whole number"),
                                            (truth.class_id.astype(int) - 1000, truth.instance, "from 0 to"),
                                            (truth.class_id[:, None], truth.instance, "whole number")):
            with self.assertRaisesRegex(pf.Error, message):
                evaluation.add_labels(class_id, instance, truth)
        with self.assertRaisesRegex(pf.Error, "3 is neither a Map nor the folder of a run"):
            pf.evaluate(3, truth)
        with self.assertRaisesRegex(pf.Error, "variant"):
            pf.Evaluation("none")


class TwoMaps(unittest.TestCase):
    def saved(self, name, rows):
        mapper = small_mapper()
        for i in range(12):
            mapper.add(segments=(ids_of(rows), ["wall", "chair"]), **arrays(i))
        mapper.finish()
        mapper.save(scratch() / name)
        return scratch() / name

    def test_a_map_is_as_it_was_and_merges_with_itself(self):
        a, b = self.saved("a.panoptic", 40), self.saved("b.panoptic", 40)
        self.assertEqual([c for c in pf.diff_maps(a, b)["changes"] if c["kind"] in ("vanished", "appeared", "moved")], [])
        self.assertGreater(pf.diff_maps(a, b)["unchanged"], 0)
        merged = scratch() / "merged.panoptic"
        counts = pf.merge_maps(a, b, merged)
        self.assertEqual(counts["same"], counts["objects_a"])
        self.assertEqual(len(pf.load_map(merged).objects("chair")), 1)
        with self.assertRaisesRegex(pf.Error, "is there already"):
            pf.merge_maps(a, b, merged)

    def test_a_single_object_is_not_enough_to_align(self):
        a, b = self.saved("a.panoptic", 40), self.saved("b.panoptic", 40)
        self.assertIsNone(pf.diff_maps(a, b)["alignment"])
        with self.assertRaisesRegex(pf.Error, "b.panoptic cannot be aligned with .*: they have no two objects"):
            pf.diff_maps(a, b, align=True)
        with self.assertRaisesRegex(pf.Error, "cannot be aligned"):
            pf.merge_maps(a, b, scratch() / "aligned.panoptic", align=True)
        self.assertFalse((scratch() / "aligned.panoptic").exists())


class Datasets(unittest.TestCase):
    def test_positions_ranges_and_lengths_agree(self):
        dataset = pf.open_dataset(home())
        self.assertEqual(len(dataset), 8)
        self.assertEqual([f.index for f in dataset.frames("1:8:3")], [dataset[p].index for p in (1, 4, 7)])
        self.assertEqual(dataset[-1].index, dataset[7].index)
        self.assertEqual(len(dataset.frames(":5")), 5)
        self.assertEqual(len(list(pf.progress(dataset.frames(":3")))), 3)

    def test_poses_and_notes_are_known_without_decoding(self):
        dataset = pf.open_dataset(home())
        np.testing.assert_array_equal(dataset.pose(-1), dataset[7].pose)
        self.assertEqual(dataset.notes["depth_scale"], 1000)
        with self.assertRaises(IndexError):
            dataset.pose(8)

    def test_progress_is_shown_where_tqdm_is_and_silent_otherwise(self):
        shown = []

        class Bar(list):
            def __init__(self, frames, **bar):
                shown.append((len(frames), bar))
                super().__init__(frames)

        frames = pf.open_dataset(home()).frames(":2")
        with mock.patch.dict(sys.modules, {"tqdm": mock.Mock(), "tqdm.auto": mock.Mock(tqdm=Bar)}):
            self.assertEqual(len(list(pf.progress(frames, desc="map"))), 2)
        self.assertEqual(shown, [(2, {"desc": "map"})])
        printed = io.StringIO()
        with mock.patch.dict(sys.modules, {"tqdm": None, "tqdm.auto": None}), contextlib.redirect_stderr(printed):
            self.assertEqual(len(list(pf.progress([1, 2, 3], desc="map"))), 3)
        self.assertEqual(printed.getvalue(), "")

    def test_a_simulation_is_stopped_by_what_progress_raises(self):
        def stop(done, frames):
            raise ValueError("enough")

        with self.assertRaisesRegex(ValueError, "enough"):
            pf.simulate(scratch() / "stopped", progress=stop, seed=3, rooms=1, frames=4, noise="none")
        self.assertEqual([p for p in scratch().iterdir() if p.name.startswith("stopped")], [])
        with self.assertRaisesRegex(pf.Error, "rooms=99.*must be between"):
            pf.simulate(scratch() / "stopped", rooms=99)

    def test_a_simulation_is_stopped_by_a_keyboard(self):
        threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT)).start()
        with self.assertRaises(KeyboardInterrupt):
            pf.simulate(scratch() / "stopped", seed=3, rooms=1, frames=2000, noise="none")
        self.assertEqual([p for p in scratch().iterdir() if p.name.startswith("stopped")], [])


class Options(unittest.TestCase):
    def test_options_read_back_as_they_were_set(self):
        options = pf.Options(preset="paper", map={"voxel_size_m": 0.03}, networks={"semantic": ["a.toml", "b.toml"]})
        options["depth.max_m"] = np.float32(5)
        options.set("labels", pathlib.Path("my labels.toml"))
        self.assertEqual(options["networks.semantic"], ["a.toml", "b.toml"])
        self.assertEqual((options["depth.max_m"], options["labels"]), (5.0, "my labels.toml"))
        self.assertEqual(pf.Options(**options.as_dict()), options)
        (scratch() / "options.toml").write_text(options.toml())
        self.assertEqual(pf.Options(file=scratch() / "options.toml"), options)
        self.assertNotEqual(pf.Options(), options)


class Stubs(unittest.TestCase):
    STUB = SOURCE / "bindings/python/panoptic/_core.pyi"

    def test_stubs_name_what_the_module_has(self):
        module = ast.parse(self.STUB.read_text())
        for node in module.body:
            if isinstance(node, ast.ClassDef):
                stub = {n.name for n in node.body if isinstance(n, ast.FunctionDef)}
                stub |= {n.target.id for n in node.body if isinstance(n, ast.AnnAssign)}
                there = {n for n, v in vars(getattr(pf._core, node.name)).items() if not n.startswith("_")}
                self.assertEqual({n for n in stub if not n.startswith("_")}, there, node.name)
        stub = {n.name for n in module.body if isinstance(n, (ast.ClassDef, ast.FunctionDef))}
        self.assertEqual(stub, {n for n in dir(pf._core) if not n.startswith("_")})

    def test_everything_says_what_it_is(self):
        for name in pf.__all__:
            self.assertTrue((inspect.getdoc(getattr(pf, name)) or "").strip(), name)

    @release_only("it reads no memory of ours")
    def test_mypy_accepts_the_examples(self):
        try:
            import mypy.api
        except ImportError:
            self.skipTest("mypy is not installed")
        files = [str(p) for p in sorted(EXAMPLES.glob("*.py"))]
        package = pathlib.Path(pf.__file__).parent.parent
        environment = os.environ | {"MYPYPATH": str(package)}
        cache = str(package.parent / "mypy_cache")
        result = subprocess.run([sys.executable, "-m", "mypy", "--warn-unused-ignores", "--cache-dir", cache, "--config-file", str(SOURCE / "tests/python/mypy.ini"), *files,
                                 str(SOURCE / "tests/python/typed.py")], capture_output=True, text=True, env=environment)
        self.assertEqual(result.returncode, 0, result.stdout)


class Examples(unittest.TestCase):
    """Each example does what its first lines say."""

    def run_example(self, name, *arguments):
        return run_script(EXAMPLES / name, *arguments)

    def test_map_a_recording_and_ask_the_map(self):
        scene, saved = scratch() / "scene.glb", scratch() / "example.panoptic"
        printed = self.run_example("01_map_a_recording.py", home(), home() / "predictions", scene, saved)
        self.assertIn("8 frames", printed)
        self.assertEqual(scene.read_bytes()[:4], b"glTF")
        thing = pf.load_map(saved).objects()[0].class_name
        self.assertIn(thing, self.run_example("03_ask_a_map.py", saved, thing))

    def test_your_own_network(self):
        self.assertIn("objects", self.run_example("02_your_own_network.py", home(), scratch() / "own.panoptic"))

    def test_a_live_loop(self):
        printed = self.run_example("05_live_loop.py", home(), home() / "predictions")
        self.assertIn("used", printed)
        self.assertIn("dropped", printed)

    def saved_to_plot(self):
        try:
            import matplotlib  # noqa: F401
        except ImportError:
            self.skipTest("matplotlib is not installed")
        mapped().save(scratch() / "plotted.panoptic")
        return scratch() / "plotted.panoptic"

    def test_plot_a_map(self):
        self.run_example("04_plot_a_map.py", self.saved_to_plot(), scratch() / "map.png")
        self.assertEqual((scratch() / "map.png").read_bytes()[1:4], b"PNG")

    def test_plan_a_way(self):
        thing = next(o for o in mapped().map.objects() if mapped().labels.is_thing(o.class_id))
        name = f"{thing.class_name.replace(' ', '_')}_{thing.id}"
        printed = self.run_example("06_plan_a_way.py", self.saved_to_plot(), name, scratch() / "way.png")
        self.assertRegex(printed, f"m to {name}|no ")
        self.assertEqual((scratch() / "way.png").read_bytes()[1:4], b"PNG")


class TheDocumentation(unittest.TestCase):
    def test_the_first_script_of_the_docs_works_at_once(self):
        text = (SOURCE / "docs/python.md").read_text()
        script = text.split("```python\n")[1].split("```")[0]
        self.assertLessEqual(len(script.splitlines()), 12)
        folder = scratch() / "newcomer"
        folder.mkdir()
        (folder / "script.py").write_text(script.replace("frames=12", "frames=2"))
        with contextlib.chdir(folder):
            run_script("script.py")
        self.assertTrue((folder / "room.glb").exists())


if __name__ == "__main__":
    unittest.main()
