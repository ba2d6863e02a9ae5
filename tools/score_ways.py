#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Scores the navigation mesh and the ways of maps of simulated homes against the true surface, for the agent of docs/planning.md.

Usage: score_ways.py TRUTH MAP [TRUTH MAP ...] [--ways 50] [--seed 1] [--json FILE]

TRUTH is a folder that `panoptic simulate` wrote, MAP the map file of it that `panoptic run --map` wrote, in the world of the recording. The
package panoptic (docs/python.md) must be importable; it reads the truth, makes the navigation mesh and finds the ways. The rest is done
here, in cells of 2.4 cm:

- Floor is true surface no more than a step above or below the height of most surface labelled floor. It is seen if the depth reading of a
  frame at the pixel nearest to its cell's centre lies at that height too. An obstacle is true surface between the step and the agent's height.
- An agent may stand where nothing but seen floor without obstacles is within its radius: no obstacle and no centre of another cell is nearer.
- IoU compares that with the triangles of the navigation mesh. Cells within 4.8 cm of the border of the truth are not counted; for the column
  "inner" also those within 4.8 cm of the border of the navigation mesh.
- Ways are asked for between random places where the agent may stand, from each of which the other can be reached.
- Ways touch if true obstacles are nearer to them than the radius less 2.4 cm; "deepest" is how much nearer."""
import argparse
import importlib.machinery
import json
import pathlib
import sys
import time
import types

import numpy as np

try:
    import panoptic
except ImportError as error:
    sys.exit(f"score_ways: {error}; set PYTHONPATH to the folder of the package panoptic (docs/python.md)")

RADIUS_M, HEIGHT_M, CLIMB_M = 0.2, 1.5, 0.05
CELL_M = 0.024
BORDER_M = 0.048
SLACK_M = 0.024
STEP_M = 0.01
EQUAL_M = 0.001  # heights closer than that are alike: a plinth may be exactly as high as the step
SIDE = 2**32
FLOOR_CLASSES = (2, 20)  # floor, floor mat, as NYU40 numbers them


class Grid:
    """Square cells over some points; masks are indexed [x, y]."""

    def __init__(self, points):
        margin = 2 * RADIUS_M
        self.low = points.min(axis=0) - margin
        self.shape = tuple(np.ceil((points.max(axis=0) + margin - self.low) / CELL_M).astype(int))

    def mask(self, points):
        """The cells that hold one of these points."""
        mask = np.zeros(self.shape, bool)
        mask[tuple(np.floor((points - self.low) / CELL_M).astype(int).T)] = True
        return mask

    def centers(self, mask):
        return self.low + (np.argwhere(mask) + 0.5) * CELL_M

    def covered(self, triangles):
        """The cells whose centres lie in one of these triangles, (N, 3, 2)."""
        mask = np.zeros(self.shape, bool)
        for corners in (triangles - self.low) / CELL_M - 0.5:
            first, last = np.ceil(corners.min(axis=0)).astype(int), np.floor(corners.max(axis=0)).astype(int)
            x, y = np.mgrid[first[0]:last[0] + 1, first[1]:last[1] + 1]
            sides = np.array([(b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]) for a, b in zip(corners, np.roll(corners, -1, axis=0))])
            mask[x, y] |= (sides >= -1e-6).all(axis=0) | (sides <= 1e-6).all(axis=0)
        return mask


def grown(mask, by_m):
    """A mask and all cells whose centres are no farther from one of it."""
    reach = int(by_m / CELL_M + 1e-6)
    padded, (width, height) = np.pad(mask, reach), mask.shape
    result = np.zeros_like(mask)
    for dx in range(-reach, reach + 1):
        for dy in range(-reach, reach + 1):
            if dx * dx + dy * dy <= (by_m / CELL_M + 1e-6)**2:
                result |= padded[reach + dx:reach + dx + width, reach + dy:reach + dy + height]
    return result


def border(mask):
    return grown(mask, BORDER_M) & grown(~mask, BORDER_M)


def bucket_keys(points, size_m):
    """One number for each square of this size; SIDE of them make a column."""
    x, y = np.floor(points / size_m).astype(np.int64).T
    return x * SIDE + y


def by_bucket(points, size_m):
    """Numbers of the points in each square of this size."""
    keys, members = np.unique(bucket_keys(points, size_m), return_inverse=True)
    order = np.argsort(members, kind="stable")
    return dict(zip(keys.tolist(), np.split(order, np.cumsum(np.bincount(members))[:-1])))


def distances(places, points, most_m):
    """From each place to the nearest of the points; inf where that is farther than `most_m`."""
    result = np.full(len(places), np.inf)
    if not len(places) or not len(points):
        return result
    squares = by_bucket(points, most_m)
    around = [dx * SIDE + dy for dx in (-1, 0, 1) for dy in (-1, 0, 1)]
    for key, members in by_bucket(places, most_m).items():
        near = [squares[key + step] for step in around if key + step in squares]
        if not near:
            continue
        others = points[np.concatenate(near)]
        for some in np.array_split(members, len(members) // 256 + 1):
            apart = [places[some, axis][:, None] - others[:, axis] for axis in range(2)]
            result[some] = np.sqrt((apart[0]**2 + apart[1]**2).min(axis=1))
    result[result > most_m] = np.inf
    return result


def surface_points(positions, triangles):
    """Corners, middles of sides and centroids: a centimetre apart on triangles of cells of 2 cm."""
    a, b, c = (positions[triangles[:, k]] for k in range(3))
    return np.concatenate([positions[np.unique(triangles)], (a + b) / 2, (b + c) / 2, (c + a) / 2, (a + b + c) / 3])


def thinned(points, to_m=0.005):
    """One point of each square of this size."""
    return points[np.unique(bucket_keys(points, to_m), return_index=True)[1]]


def only_file(folder, pattern):
    found = sorted(pathlib.Path(folder).glob(pattern))
    if len(found) != 1:
        sys.exit(f"score_ways: {folder} holds {len(found)} files {pattern}; name a folder that panoptic simulate wrote")
    return found[0]


def depth_frames(path):
    """Camera matrix, metres of a unit of depth, and (world_from_camera, depth) of every frame of a .sens file."""
    loader = importlib.machinery.SourceFileLoader("unpack_sens", str(pathlib.Path(__file__).with_name("unpack_sens")))
    unpack_sens = types.ModuleType(loader.name)
    sys.dont_write_bytecode = True  # nothing beside the tools
    loader.exec_module(unpack_sens)
    sens = unpack_sens.Sens(path)

    def frames():
        for _ in range(sens.frame_count):
            pose, _, depth = sens.frame()
            yield np.reshape(pose, (4, 4)), np.frombuffer(depth, "<u2").reshape(sens.depth_height, sens.depth_width)

    return np.reshape(sens.depth_intrinsic, (4, 4))[:3, :3], 1 / sens.units_per_m, frames()


def seen(places, floor_m, path):
    """Which of these places on the floor a camera of the recording has seen."""
    intrinsics, unit_m, frames = depth_frames(path)
    world = np.column_stack([places, np.full(len(places), floor_m)])
    result = np.zeros(len(places), bool)
    for pose, depth in frames:
        waiting = np.flatnonzero(~result)
        camera = (world[waiting] - pose[:3, 3]) @ pose[:3, :3]
        ahead = camera[:, 2] > 0.05
        waiting, camera = waiting[ahead], camera[ahead]
        u, v = np.rint((camera[:, :2] / camera[:, 2:]) @ intrinsics[:2, :2].T + intrinsics[:2, 2]).astype(int).T
        inside = (u >= 0) & (v >= 0) & (u < depth.shape[1]) & (v < depth.shape[0])
        waiting, u, v = waiting[inside], u[inside], v[inside]
        reading = depth[v, u] * unit_m
        rays = np.column_stack([u, v, np.ones_like(u)]) @ np.linalg.inv(intrinsics).T
        heights = reading * (rays @ pose[2, :3]) + pose[2, 3]
        result[waiting] = (reading > 0) & (np.abs(heights - floor_m) <= CLIMB_M + EQUAL_M)
    return result


class Truth:
    """Where the agent may stand, by the true surface; `obstacles` are points of it seen from above."""

    def __init__(self, folder, more_points):
        mesh = panoptic.read_scan_truth(folder)
        positions = mesh.positions.astype(float)
        is_floor = np.isin(mesh.class_id, FLOOR_CLASSES)
        if not is_floor.any():
            sys.exit(f"score_ways: the true mesh of {folder} has no floor")
        self.floor_m = float(np.median(positions[is_floor, 2]))
        low = positions[mesh.triangles, 2].min(axis=1) < self.floor_m + HEIGHT_M
        points = surface_points(positions, mesh.triangles[low])
        above_m = points[:, 2] - self.floor_m
        self.obstacles = thinned(points[(above_m > CLIMB_M + EQUAL_M) & (above_m < HEIGHT_M), :2])
        ground = points[np.abs(above_m) <= CLIMB_M + EQUAL_M, :2]
        self.grid = Grid(np.concatenate([self.obstacles, ground, more_points]))
        self.blocked = self.grid.mask(self.obstacles)
        self.floor = self.grid.mask(ground) & ~self.blocked
        self.seen = self.floor.copy()
        self.seen[self.floor] = seen(self.grid.centers(self.floor), self.floor_m, only_file(folder, "*.sens"))
        self.walkable = self.seen & ~grown(~self.seen, RADIUS_M - 1e-6)
        self.walkable[self.walkable] = distances(self.grid.centers(self.walkable), self.obstacles, RADIUS_M) >= RADIUS_M


def islands(mask):
    """The cells of each part that hangs together by sides."""
    left, parts = set(map(tuple, np.argwhere(mask))), []
    while left:
        waiting = [left.pop()]
        part = []
        while waiting:
            x, y = waiting.pop()
            part.append((x, y))
            beside = {(x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)} & left
            left -= beside
            waiting.extend(beside)
        parts.append(np.array(sorted(part)))
    return parts


def random_pairs(truth, count, random):
    """Places of the truth between which there is a way, (N, 2, 3), every start as likely as any other."""
    parts = islands(truth.walkable)
    sizes = np.array([len(part) for part in parts])
    if not parts:
        return np.zeros((0, 2, 3))
    chosen = random.choice(len(parts), size=count, p=sizes / sizes.sum())
    cells = np.array([parts[n][random.integers(sizes[n], size=2)] for n in chosen])
    places = truth.grid.low + (cells + 0.5) * CELL_M
    return np.concatenate([places, np.full((count, 2, 1), truth.floor_m)], axis=2)


def dense(points):
    """Points along a line, no farther apart than STEP_M."""
    parts = [points[:1]]
    for a, b in zip(points, points[1:]):
        steps = max(1, int(np.ceil(np.linalg.norm(b - a) / STEP_M)))
        parts.append(a + (b - a) * np.arange(1, steps + 1)[:, None] / steps)
    return np.concatenate(parts)


def asked(mesh, start, goal):
    """A way's points from above, a centimetre apart, and why there is none."""
    try:
        way = mesh.path(*mesh.frame.to_grid([start, goal]))
    except panoptic.Error as error:
        return np.zeros((0, 2)), str(error)
    return (dense(mesh.frame.to_world(way.points_m)[:, :2]), "") if way else (np.zeros((0, 2)), way.why_not)


def score_ways(truth, mesh, count, random):
    """One dict for each pair: places in the world, why no way was found, or how deep it runs into true surface, and where."""
    pairs = random_pairs(truth, count, random)
    lines, why_not = zip(*(asked(mesh, *pair) for pair in pairs)) if len(pairs) else ((), ())
    nearest = distances(np.concatenate([np.zeros((0, 2)), *lines]), truth.obstacles, RADIUS_M)
    ways, first = [], 0
    for (start, goal), line, why in zip(pairs, lines, why_not):
        way = {"start": start[:2].tolist(), "goal": goal[:2].tolist(), "why_not": why}
        if not why:
            of_line = nearest[first:first + len(line)]
            way["deepest_m"] = max(0.0, RADIUS_M - SLACK_M - float(of_line.min()))
            way["nearest_at"] = line[of_line.argmin()].tolist()
        ways.append(way)
        first += len(line)
    return ways


def made_mesh(path):
    """The navigation mesh of a map file, and how many ms it took on the clock and of the processors."""
    saved = panoptic.load_map(path)
    frame = panoptic.up_frame(saved)
    clock, processors = time.perf_counter(), time.process_time()
    mesh = panoptic.NavigationMesh(saved, frame, panoptic.AgentSize(radius_m=RADIUS_M, height_m=HEIGHT_M, climb_m=CLIMB_M))
    return mesh, 1000 * (time.perf_counter() - clock), 1000 * (time.process_time() - processors)


def mesh_triangles(mesh):
    """Seen from above, in the world."""
    vertices, corners = mesh.triangles()
    return mesh.frame.to_world(vertices)[:, :2][corners] if len(corners) else np.zeros((0, 3, 2))


def score(truth_folder, map_file, options):
    mesh, clock_ms, processor_ms = made_mesh(map_file)
    triangles = mesh_triangles(mesh)
    truth = Truth(truth_folder, triangles.reshape(-1, 2))
    found = truth.grid.covered(triangles)
    counted = ~border(truth.walkable)
    inner = counted & ~border(found)
    return {
        "truth": str(truth_folder), "map": str(map_file),
        "true_m2": float(truth.walkable.sum() * CELL_M**2), "found_m2": float(found.sum() * CELL_M**2),
        "common": [int((truth.walkable & found & where).sum()) for where in (counted, inner)],
        "either": [int(((truth.walkable | found) & where).sum()) for where in (counted, inner)],
        "missed_m2": float((truth.walkable & ~found & counted).sum() * CELL_M**2),
        "invented_m2": float((found & ~truth.walkable & counted).sum() * CELL_M**2),
        "mesh_ms": clock_ms, "mesh_processor_ms": processor_ms,
        "ways": score_ways(truth, mesh, options.ways, np.random.default_rng(options.seed)),
    }


def summary(homes):
    """The numbers of a row, for one home or for several together."""
    ways = [way for home in homes for way in home["ways"]]
    depths = [way["deepest_m"] for way in ways if "deepest_m" in way]
    shares = [sum(home["common"][k] for home in homes) / max(1, sum(home["either"][k] for home in homes)) for k in range(2)]
    return {
        "true_m2": sum(home["true_m2"] for home in homes), "found_m2": sum(home["found_m2"] for home in homes),
        "iou": shares[0], "inner_iou": shares[1],
        "ways": len(ways), "ways_found": len(depths), "ways_touching": sum(depth > 0 for depth in depths),
        "deepest_m": max(depths, default=0.0),
        "mesh_ms": max(home["mesh_ms"] for home in homes), "mesh_processor_ms": max(home["mesh_processor_ms"] for home in homes),
    }


def row(name, s):
    found, touching = s["ways_found"] / max(1, s["ways"]), s["ways_touching"] / max(1, s["ways_found"])
    return (f"{name:<24} {s['true_m2']:>7.2f} {s['found_m2']:>8.2f} {s['iou']:>6.3f} {s['inner_iou']:>6.3f} {s['ways']:>6} {100 * found:>7.2f} "
            f"{100 * touching:>7.2f} {1000 * s['deepest_m']:>8.1f} {s['mesh_ms']:>7.0f} {s['mesh_processor_ms']:>7.0f}")


def parsed():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pairs", nargs="+", metavar="TRUTH MAP")
    parser.add_argument("--ways", type=int, default=50, help="random pairs of places in each home")
    parser.add_argument("--seed", type=int, default=1, help="for the pairs")
    parser.add_argument("--json", type=pathlib.Path, help="file for all numbers and every way")
    options = parser.parse_args()
    if len(options.pairs) % 2 or options.ways < 0:
        parser.error("folders and maps come in pairs, and ways are not negative")
    return options


def main():
    options = parsed()
    print(f"{'home':<24} {'true m2':>7} {'found m2':>8} {'IoU':>6} {'inner':>6} {'ways':>6} {'found %':>7} {'touch %':>7} {'deep mm':>8} "
          f"{'mesh ms':>7} {'cpu ms':>7}")
    homes = []
    try:
        for truth_folder, map_file in zip(options.pairs[::2], options.pairs[1::2]):
            homes.append(score(truth_folder, map_file, options))
            print(row(only_file(truth_folder, "*.sens").stem, summary(homes[-1:])), flush=True)
    except (panoptic.Error, OSError) as error:
        sys.exit(f"score_ways: {error}")
    if len(homes) > 1:
        print(row("all (ms: the longest)", summary(homes)))
    if options.json:
        options.json.write_text(json.dumps({"total": summary(homes), "homes": homes}, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
