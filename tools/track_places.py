#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""How well a camera is found again in simulated homes: after it was carried off (simulate --jumps), and at the start of a further visit
(run --track --in).

Usage: track_places.py PANOPTIC OUT [--seeds 3 5 9] [--rooms 1] [--frames 600] [--jumps 4] [--voxel 0.03] [--starts]

PANOPTIC is the program. Prints a line for each jump and, with --starts, for each start: the frames up to the first jump are mapped, and every
stretch between two jumps is a further visit. The camera is found if it is within 10 cm and 5 degrees of the truth; a frame that is tracked
and farther off is wrong. Everything is left in OUT, and what is there already is not made again."""
import argparse
import json
import math
import pathlib
import struct
import subprocess

NEAR_M, NEAR_DEG, SOON = 0.10, 5.0, 30
SEEN_M, SEEN_DEG = 0.4, 20.0  # as the simulator says what was seen before
HEADER_MATRICES = 4 * 64


def call(*arguments, codes=(0,)):
    result = subprocess.run([str(a) for a in arguments], capture_output=True, text=True)
    if result.returncode not in codes:
        raise SystemExit(f"{' '.join(str(a) for a in arguments)}\n{result.stderr}")
    return result


def rotation_of(qx, qy, qz, qw):
    return [[1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy - qz * qw), 2 * (qx * qz + qy * qw)],
            [2 * (qx * qy + qz * qw), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz - qx * qw)],
            [2 * (qx * qz - qy * qw), 2 * (qy * qz + qx * qw), 1 - 2 * (qx * qx + qy * qy)]]


def product(a, b):
    """Of two poses, each a rotation and a translation."""
    (ra, ta), (rb, tb) = a, b
    rotation = [[sum(ra[i][k] * rb[k][j] for k in range(3)) for j in range(3)] for i in range(3)]
    return rotation, [sum(ra[i][k] * tb[k] for k in range(3)) + ta[i] for i in range(3)]


def inverse(pose):
    r, t = pose
    turned = [[r[j][i] for j in range(3)] for i in range(3)]
    return turned, [-sum(turned[i][k] * t[k] for k in range(3)) for i in range(3)]


def apart(a, b):
    """Metres and degrees."""
    r, t = product(inverse(a), b)
    cosine = max(-1.0, min(1.0, (r[0][0] + r[1][1] + r[2][2] - 1) / 2))
    return math.dist(t, [0, 0, 0]), math.degrees(math.acos(cosine))


def is_within(a, b, metres, degrees):
    distance, angle = apart(a, b)
    return distance <= metres and angle <= degrees


def trajectory(path):
    """Poses by their time as it is written."""
    poses = {}
    for line in path.read_text().splitlines():
        if line.startswith("#"):
            continue
        time, *numbers = line.split()
        values = [float(n) for n in numbers]
        poses[time] = rotation_of(*values[3:]), values[:3]
    return poses


def cut_sens(source, target, begin, end):
    """Writes frames begin to end, end excluded, of a .sens file as another."""
    with source.open("rb") as file:
        head = file.read(4 + 8)
        head += file.read(struct.unpack_from("<Q", head, 4)[0] + HEADER_MATRICES + 2 * 4 + 4 * 4 + 4)
        count = struct.unpack("<Q", file.read(8))[0]
        frames = []
        for i in range(count):
            fixed = file.read(64 + 4 * 8)
            sizes = struct.unpack_from("<QQ", fixed, 64 + 16)
            if begin <= i < end:
                frames.append(fixed + file.read(sum(sizes)))
            else:
                file.seek(sum(sizes), 1)
    target.write_bytes(head + struct.pack("<Q", len(frames)) + b"".join(frames) + struct.pack("<Q", 0))


class Home:
    def __init__(self, options, seed):
        self.options, self.seed = options, seed
        self.folder = options.out / f"home_{seed}"
        if not self.folder.exists():
            call(options.panoptic, "simulate", "--seed", seed, "--rooms", options.rooms, "--frames", options.frames, "--jumps", options.jumps,
                 "--noise", options.noise, "--predictions", "none", "-o", self.folder)
        self.sens = next(self.folder.glob("*.sens"))
        truth = json.loads((self.folder / "jumps.json").read_text())
        self.jumps, self.frames = truth["jumps"], truth["frames"]
        self.ends = [j["frame"] for j in self.jumps[1:]] + [self.frames]

    def run(self, name, recording, *more):
        out = self.options.out / f"{name}_{self.seed}"
        if not (out / "report.json").exists():
            call(self.options.panoptic, "run", recording, "--set", f"map.voxel_size_m={self.options.voxel}", "--set",
                 "regularizer.enabled=false", "--no-pictures", "--no-preflight", "-o", out, *more, codes=(0, 1))
        return out

    def after_jumps(self):
        out = self.run("jumps", self.sens, "--track")
        truth, found = trajectory(out / "given_trajectory.txt"), trajectory(out / "trajectory.txt")
        times = list(truth)
        world = product(truth[times[0]], inverse(found[times[0]]))
        off = {i: apart(truth[t], product(world, found[t])) for i, t in enumerate(times) if t in found}
        first = self.jumps[0]["frame"]
        drift = max((off[i][0] for i in off if i < first), default=0)
        for jump, end in zip(self.jumps, self.ends):
            yield jump["seen_before"], drift, row_of(off, jump["frame"], end)

    def starts(self):
        """Each stretch between jumps, found in the map of the frames before the first one."""
        first = self.jumps[0]["frame"]
        mapped = self.part("part", 0, first)
        saved = self.options.out / f"map_{self.seed}.panoptic"
        if not saved.exists():
            self.run("first", mapped, "--map", saved)
        before = list(trajectory(self.options.out / f"first_{self.seed}" / "trajectory.txt").values())
        for n, (jump, end) in enumerate(zip(self.jumps, self.ends)):
            visit = self.part(f"visit{n}", jump["frame"], end)
            new = self.options.out / f"map_{self.seed}_{n}.panoptic"
            out = self.run(f"start{n}", visit, "--track", "--in", saved, "--map", new)
            truth, found = trajectory(out / "given_trajectory.txt"), trajectory(out / "trajectory.txt")
            off = {i: apart(truth[t], found[t]) for i, t in enumerate(truth) if t in found}
            start = next(iter(truth.values()))
            yield any(is_within(b, start, SEEN_M, SEEN_DEG) for b in before), 0, row_of(off, 0, len(truth))

    def part(self, name, begin, end):
        path = self.options.out / f"{name}_{self.seed}.sens"
        if not path.exists():
            cut_sens(self.sens, path, begin, end)
        return path


def row_of(off, begin, end):
    """The first known frame after `begin`, counted from there, how far off it is, known and wrong frames, and all."""
    known = [i for i in range(begin, end) if i in off]
    wrong = [i for i in known if off[i][0] > NEAR_M or off[i][1] > NEAR_DEG]
    return (known[0] - begin if known else None, off[known[0]] if known else None, len(known), len(wrong), end - begin)


def print_rows(name, rows):
    print(f"\n| {name} | seen before | found after, frames | off, cm | off, degrees | known | wrong | of frames |\n|---|---|---|---|---|---|---|---|")
    seen = soon = wrong = 0
    for label, is_seen, (after, off, known, bad, frames) in rows:
        at = f"{after} | {100 * off[0]:.1f} | {off[1]:.2f}" if off else "never | | "
        print(f"| {label} | {'yes' if is_seen else 'no'} | {at} | {known} | {bad} | {frames} |")
        is_right = off is not None and off[0] <= NEAR_M and off[1] <= NEAR_DEG
        seen += is_seen
        soon += is_seen and is_right and after < SOON
        wrong += off is not None and not is_right
    print(f"\nseen before: {seen}, of these found within {SOON} frames: {soon}; found at a wrong place: {wrong}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("panoptic", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--seeds", type=int, nargs="+", default=[3, 5, 9])
    parser.add_argument("--rooms", type=int, default=1)
    parser.add_argument("--frames", type=int, default=600)
    parser.add_argument("--jumps", type=int, default=4)
    parser.add_argument("--noise", default="kinect")
    parser.add_argument("--voxel", type=float, default=0.03)
    parser.add_argument("--starts", action="store_true", help="starts in a saved map, not jumps")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    rows = []
    for seed in options.seeds:
        home = Home(options, seed)
        for n, (is_seen, drift, row) in enumerate(home.starts() if options.starts else home.after_jumps()):
            rows.append((f"home {seed}, {n + 1}" + (f" (drift before {100 * drift:.1f} cm)" if n == 0 and drift else ""), is_seen, row))
    print_rows("start" if options.starts else "jump", rows)


if __name__ == "__main__":
    main()
