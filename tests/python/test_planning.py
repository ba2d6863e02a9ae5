# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Frames, grids, distances, ways and plans are those of the files of `panoptic plan`."""
import functools
import json
import unittest

import numpy as np

import panoptic as pf
from home import COARSE, arrays, home, ids_of, mapped, scratch, small_mapper


@functools.cache
def frame():
    return pf.up_frame(mapped().map)


@functools.cache
def grids():
    return pf.floor_grids(mapped().map, frame(), bands=[(0.6, 0.9)])


@functools.cache
def navigation():
    return pf.NavigationMesh(mapped().map, frame(), pf.AgentSize(radius_m=0.1))


@functools.cache
def written():
    """The folder of a plan, and what write_plan says of it."""
    folder = scratch() / "plan"
    steps = []
    summary = pf.write_plan(folder, mapped().map, bands=[(0.6, 0.9)], progress=lambda *step: steps.append(step))
    assert steps == [(i, 9) for i in range(10)], steps
    return folder, summary


def pgm(name):
    """The bytes of a grid as its file has them, the row of the lowest y first."""
    data = (written()[0] / name).read_bytes()
    header, size, _, pixels = data.split(b"\n", 3)
    assert header == b"P5"
    width, height = map(int, size.split())
    return np.frombuffer(pixels, np.uint8).reshape(height, width)[::-1]


def walkable_places():
    """Places of the floor where the agent of navigation() may stand, on the largest island or any."""
    rows, columns = np.nonzero(grids().standing == pf.FREE)
    places = np.column_stack([columns + 0.5, rows + 0.5]) * grids().cell_m + grids().origin_m
    return [np.array([x, y, 0.0]) for x, y in places if navigation().is_walkable([x, y, 0])]


class Frames(unittest.TestCase):
    def test_z_is_up_and_points_go_there_and_back(self):
        np.testing.assert_allclose(frame().up @ mapped().map.up, 1, atol=0.05)
        points = np.array([[1, 2, 3], [-0.5, 0, 0.25]])
        np.testing.assert_allclose(frame().to_world(frame().to_grid(points)), points, atol=1e-12)
        np.testing.assert_allclose(frame().to_grid(points[0]), frame().to_grid(points)[0])
        np.testing.assert_allclose(frame().grid_from_world @ frame().world_from_grid, np.eye(4), atol=1e-12)
        own = pf.UpFrame(frame().grid_from_world)
        np.testing.assert_array_equal(own.up, frame().up)

    def test_a_saved_map_knows_where_up_is(self):
        path = scratch() / "upright.panoptic"
        mapped().save(path)
        np.testing.assert_allclose(pf.load_map(path).up, mapped().up, atol=1e-12)
        np.testing.assert_allclose(pf.up_frame(pf.load_map(path)).grid_from_world, frame().grid_from_world, atol=1e-12)


class Grids(unittest.TestCase):
    def test_grids_are_those_of_the_files(self):
        space_of = {0: pf.OCCUPIED, 205: pf.UNKNOWN, 254: pf.FREE}
        for name, grid in (("grid.pgm", grids().standing), ("grid_0.6_0.9.pgm", grids().bands[0])):
            expected = np.vectorize(space_of.get)(pgm(name))
            np.testing.assert_array_equal(grid, expected, name)
            self.assertGreater((grid == pf.FREE).sum(), 100)
        lines = dict(line.split(": ") for line in (written()[0] / "grid.yaml").read_text().splitlines())
        np.testing.assert_allclose(json.loads(lines["origin"])[:2], grids().origin_m, rtol=1e-5)
        self.assertAlmostEqual(float(lines["resolution"]), grids().cell_m)

    def test_the_names_of_what_is_there_are_seen_not_copied(self):
        class_id, is_seen = grids().class_id, grids().is_seen
        self.assertEqual((class_id.dtype, is_seen.dtype, class_id.shape), (np.uint16, bool, grids().standing.shape))
        self.assertEqual(class_id[~is_seen].max(), 0)
        self.assertIn("floor", {mapped().labels.name_of(int(i)) for i in np.unique(class_id)})
        address = class_id.__array_interface__["data"][0]
        self.assertEqual(address, grids().class_id.__array_interface__["data"][0])
        with self.assertRaises(ValueError):
            class_id[0, 0] = 1

    def test_a_map_without_surface_has_no_frame_and_no_cells(self):
        empty = small_mapper().map
        with self.assertRaisesRegex(pf.Error, "surface"):
            pf.up_frame(empty)
        none = pf.floor_grids(empty, frame(), bands=[(0, 1)])
        self.assertEqual((none.standing.size, none.bands[0].size, none.class_id.size), (0, 0, 0))


class Distances(unittest.TestCase):
    def field(self):
        return pf.DistanceField(mapped().map, frame(), cell_m=written()[1]["cell_m"])

    def test_all_values_are_those_of_the_file(self):
        values, origin_m = self.field().values()
        np.testing.assert_array_equal(values, np.load(written()[0] / "esdf.npy"))
        about = json.loads((written()[0] / "esdf.json").read_text())
        np.testing.assert_allclose(origin_m, about["origin_m"])
        field = self.field()
        z, y, x = np.argwhere(np.isfinite(values))[1234]
        self.assertAlmostEqual(field.distance_at(origin_m + np.array([x, y, z]) * field.cell_m), float(values[z, y, x]), places=5)

    def test_many_answers_are_those_of_single_questions(self):
        field, random = self.field(), np.random.default_rng(3)
        values, origin_m = field.values()
        points = origin_m + random.random((200, 3)) * np.array(values.shape[::-1]) * field.cell_m
        distances, gradients = field.distances_m(points), field.gradients(points)
        self.assertGreater(np.isfinite(distances).sum(), 20)
        self.assertGreater(np.isnan(distances).sum(), 0)
        for point, distance, gradient in zip(points, distances, gradients):
            one, way = field.distance_m(point), field.gradient(point)
            self.assertEqual(one is None, np.isnan(distance))
            self.assertEqual(way is None, np.isnan(gradient).any())
            if one is not None:
                self.assertEqual(one, distance)
            if way is not None:
                np.testing.assert_array_equal(way, gradient)
                self.assertAlmostEqual(np.linalg.norm(way), 1)

    def test_it_follows_a_map_that_grows_and_one_that_is_corrected(self):
        mapper = pf.Mapper(pf.Options(map=COARSE["map"] | {"log": "reference"}), labels=mapped().labels)
        recorded = list(pf.open_dataset(home()))
        for recorded_frame in recorded[:3]:
            mapper.add(recorded_frame)
        field = pf.DistanceField(mapper.map, frame(), cell_m=0.1)
        for recorded_frame in recorded[3:]:
            mapper.add(recorded_frame)

        def expect_as_made_anew():
            field.update()
            values, origin_m = pf.DistanceField(mapper.map, frame(), cell_m=0.1).values()
            np.testing.assert_array_equal(field.values()[0], values)
            np.testing.assert_array_equal(field.values()[1], origin_m)

        expect_as_made_anew()
        same = {f.index: recorded[0].pose for f in recorded}  # all looked at what the first saw: less is there
        before = len(mapper.map.blocks())
        self.assertGreater(mapper.update_poses(same, {f.index: f for f in recorded}.__getitem__)["frames"], 0)
        self.assertNotEqual(len(mapper.map.blocks()), before)
        expect_as_made_anew()


class Ways(unittest.TestCase):
    def test_a_way_leads_from_start_to_goal(self):
        places = walkable_places()
        self.assertGreater(len(places), 10)
        some = places[::len(places) // 9]
        ways = [(navigation().path(start, goal), start) for start in some for goal in some]
        way, start = max((w for w in ways if w[0]), key=lambda w: w[0].length_m)
        self.assertGreater(way.length_m, 0.5)
        self.assertAlmostEqual(np.linalg.norm(np.diff(way.points_m, axis=0), axis=1).sum(), way.length_m)
        np.testing.assert_allclose(way.points_m[0][:2], start[:2], atol=0.15)
        for step in way.points_m:
            self.assertLess(np.linalg.norm(np.array(places)[:, :2] - step[:2], axis=1).min(), 0.15)
        with self.assertRaisesRegex(pf.Error, "start"):
            navigation().path([50, 50, 0], start)

    def test_a_way_leads_to_an_object(self):
        names = {f"{o.class_name.replace(' ', '_')}_{o.id}": o.id for o in mapped().map.objects() if mapped().labels.is_thing(o.class_id)}
        name, expected = next(iter(names.items()))
        self.assertEqual(mapped().map.node_named(name), expected)
        ways = [navigation().path_to(walkable_places()[0], i) for i in names.values()]
        self.assertTrue(all(w.found or w.why_not for w in ways))
        with self.assertRaisesRegex(pf.Error, "no such|no node|there is no|none"):
            mapped().map.node_named("submarine_7")
        for wrong in (0, -1, 1 << 40, 999_999):
            with self.assertRaises(pf.Error):
                navigation().path_to(walkable_places()[0], wrong)

    def test_polygons_cover_the_floor(self):
        vertices, triangles = navigation().triangles()
        a, b, c = (vertices[triangles[:, i]][:, :2] for i in range(3))
        areas = ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
        self.assertTrue((areas > -1e-4).all(), "counter-clockwise from above")
        self.assertAlmostEqual(areas.sum(), navigation().area_m2, delta=0.35 * navigation().area_m2 + 0.2)
        self.assertGreater(navigation().islands, 0)
        self.assertEqual(pf.NavigationMesh(mapped().map).detour_bytes(), (written()[0] / "navmesh.bin").read_bytes())


class Plans(unittest.TestCase):
    def test_a_plan_is_that_of_the_files(self):
        plan = pf.plan_home(mapped().map, frame())
        files = json.loads((written()[0] / "affordances.json").read_text())
        rooms = json.loads((written()[0] / "rooms.json").read_text())["rooms"]
        for mine, theirs in ((plan.seats, files["seats"]), (plan.lying_places, files["lying_places"]), (plan.doors, files["doors"]),
                             (plan.table_tops, files["table_tops"]), (plan.rooms, rooms)):
            self.assertEqual(len(mine), len(theirs))
        for mine, theirs in zip(plan.seats, files["seats"]):
            np.testing.assert_allclose(mine["position"], theirs["position"], atol=1e-4)
            self.assertEqual((mine["object"], mine["has_back"]), (theirs["object"], theirs["has_back"]))
        for mine, theirs in zip(plan.rooms, rooms):
            np.testing.assert_allclose(mine["polygon"], theirs["polygon"], atol=1e-4)
            self.assertEqual((mine["class_name"], mine["objects"]), (theirs["class"], theirs["objects"]))
        self.assertGreater(len(plan.walls) + len(plan.furniture), 0)
        self.assertEqual(plan.svg(), (written()[0] / "floorplan.svg").read_text())
        plan.save(scratch() / "home_plan")
        self.assertEqual((scratch() / "home_plan/rooms.json").read_bytes(), (written()[0] / "rooms.json").read_bytes())

    def test_a_way_is_written_in_the_world(self):
        start = frame().to_world(walkable_places()[0])
        summary = pf.write_plan(scratch() / "way", mapped().map, agent=pf.AgentSize(radius_m=0.1), start=start, goal=start)
        self.assertEqual(summary["why_not"], "")
        path = json.loads((scratch() / "way/path.json").read_text())
        np.testing.assert_allclose(frame().to_world(path["points"][0])[:2], start[:2], atol=0.3)

    def test_what_progress_raises_ends_a_plan(self):
        def stop(step, steps):
            if step == 2:
                raise ValueError("enough")

        with self.assertRaisesRegex(ValueError, "enough"):
            pf.write_plan(scratch() / "stopped_plan", mapped().map, progress=stop)
        self.assertFalse((scratch() / "stopped_plan").exists(), "nothing is written before the third step")
        self.assertEqual(len(mapped().map_hash()), 16, "the map was given back")

    def test_what_makes_no_sense_is_refused(self):
        room = mapped().map
        for pattern, use in (("both", lambda: pf.write_plan("x", room, start=[0, 0, 0])), ("height", lambda: pf.AgentSize(height_m=-1)),
                             ("radius", lambda: pf.AgentSize(radius_m=float("nan"))), ("band", lambda: pf.floor_grids(room, bands=[(1, 0)])),
                             ("cells", lambda: pf.DistanceField(room, cell_m=0)), ("cap", lambda: pf.DistanceField(room, cap_m=float("inf"))),
                             ("finite", lambda: pf.DistanceField(room).distances_m([[0, 0, np.nan]])), ("N, 3", lambda: frame().to_grid([[1, 2]])),
                             ("direction", lambda: pf.up_frame(room, [0, 0, 0])), ("10 km", lambda: pf.UpFrame(np.eye(4) + np.eye(4, k=3) * 1e7)), ("rigid", lambda: pf.UpFrame(2 * np.eye(4) - np.diag([0, 0, 0, 1.0])))):
            with self.assertRaisesRegex(pf.Error, pattern, msg=pattern) as caught:
                use()
            self.assertNotIn("\n", str(caught.exception))
        for use in (lambda: pf.DistanceField(None), lambda: pf.NavigationMesh(None), lambda: pf.up_frame(None), lambda: pf.plan_home(mapped()),
                    lambda: pf.OnlinePipeline(None)):
            with self.assertRaises(TypeError):
                use()

    def test_a_mapper_that_is_at_work_is_not_planned_with(self):
        mapper = small_mapper()
        mapper.add(segments=(ids_of(), ["wall", "chair"]), **arrays())
        field = pf.DistanceField(mapper.map, frame())
        pipeline = pf.OnlinePipeline(mapper)
        for use in (field.update, lambda: field.distance_m([0, 0, 0]), lambda: pf.floor_grids(mapper.map, frame()),
                    lambda: mapper.map.free_space.cells(), lambda: mapper.map.up):
            with self.assertRaisesRegex(pf.Error, "in use by an online pipeline"):
                use()
        pipeline.finish()
        field.update()


class FreeSpace(unittest.TestCase):
    def test_cells_are_those_of_points(self):
        space = mapped().map.free_space
        index, known = space.cells()
        self.assertEqual(set(np.unique(known)), {pf.FREE, pf.OCCUPIED})
        centers = (index + 0.5) * space.cell_size_m
        np.testing.assert_array_equal(space.at(centers), known)
        self.assertEqual(space.at([1000, 1000, 1000]).tolist(), [pf.UNKNOWN])
        record = space.record(centers[known == pf.FREE][0])
        self.assertGreater(record["evidence"], 0)
        self.assertIsNotNone(record["empty_at"])
        self.assertIsNone(space.record([1e9, 0, 0]))


class PoseFiles(unittest.TestCase):
    def test_corrections_are_read_as_the_program_reads_them(self):
        pose = np.eye(4)
        pose[0, 3] = 0.25
        (scratch() / "updates.jsonl").write_text(json.dumps({"at_frame": 12, "poses": [{"frame": 3, "pose": pose.ravel().tolist()}]}) + "\n")
        ((at_frame, poses),) = pf.read_pose_updates(scratch() / "updates.jsonl")
        self.assertEqual((at_frame, list(poses)), (12, [3]))
        np.testing.assert_array_equal(poses[3], pose)
        (scratch() / "poses.txt").write_text("".join(f"{t} {t} 0 0 0 0 0 1\n" for t in (0.1, 0.2, 0.3)))
        corrected = pf.read_corrected_poses(scratch() / "poses.txt", {7: 0.1, 8: 0.201, 9: 0.3})
        self.assertEqual(sorted(corrected), [7, 8, 9])
        self.assertAlmostEqual(corrected[8][0, 3], 0.2)
        with self.assertRaises(pf.Error):
            pf.read_corrected_poses(scratch() / "poses.txt", {7: float("nan")})
        with self.assertRaises(pf.Error):
            pf.read_pose_updates(__file__)


if __name__ == "__main__":
    unittest.main()
