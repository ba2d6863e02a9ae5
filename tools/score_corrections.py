#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""What corrected poses are worth: simulated homes whose tracker drifts, mapped as it is, corrected at the end, corrected five times on the way, and
with true poses.

Usage: score_corrections.py PANOPTIC OUT [--seeds 1 2 3 4 5] [--rooms 3] [--frames 400] [--predictions oracle] [--voxel 0.024]

PANOPTIC is the program. Prints a table in Markdown; everything is left in OUT, and what is there already is not made again."""
import argparse
import json
import pathlib
import subprocess


def call(*arguments):
    result = subprocess.run([str(a) for a in arguments], capture_output=True, text=True)
    if result.returncode != 0:
        raise SystemExit(f"{' '.join(str(a) for a in arguments)}\n{result.stderr}")


def true_poses(home):
    path = next(home.glob("*_true_poses.txt"))
    poses = {}
    for line in path.read_text().splitlines():
        if line and not line.startswith("#"):
            numbers = [float(x) for x in line.split()]
            poses[int(numbers[0])] = (numbers[1:] + [0, 0, 0, 1])[:16]
    return path, poses


def write_updates(path, poses, moments):
    """At each moment the SLAM system knows where the camera was so far."""
    frames = sorted(poses)
    with path.open("w") as out:
        for moment in range(1, moments + 1):
            last = frames[len(frames) * moment // (moments + 1)]
            known = [{"frame": f, "pose": poses[f]} for f in frames if f <= last]
            out.write(json.dumps({"at_frame": last, "poses": known}) + "\n")
        out.write(json.dumps({"at_frame": frames[-1], "poses": [{"frame": f, "pose": poses[f]} for f in frames]}) + "\n")


class Home:
    def __init__(self, options, seed):
        self.options, self.seed = options, seed
        self.folder = options.out / f"home_{seed}"
        if not self.folder.exists():
            self.simulate(self.folder, "drift")

    def simulate(self, folder, noise):
        o = self.options
        call(o.panoptic, "simulate", "--seed", self.seed, "--rooms", o.rooms, "--frames", o.frames, "--noise", noise, "--predictions",
             o.predictions, "-o", folder)

    def run(self, name, home, *more):
        out = self.options.out / f"{name}_{self.seed}"
        if not (out / "report.json").exists():
            call(self.options.panoptic, "run", home, "--predictions", home / "predictions", "--set",
                 f"map.voxel_size_m={self.options.voxel}", "--no-pictures", "-o", out, *more)
        return out

    def scores(self, map_or_run):
        path = self.options.out / f"scores_{self.seed}_{pathlib.Path(map_or_run).stem}.json"
        if not path.exists():
            call(self.options.panoptic, "eval", map_or_run, "--gt", self.folder, "--json", path)
        return json.loads(path.read_text())

    def rows(self):
        path, poses = true_poses(self.folder)
        drifting_map = self.options.out / f"drifting_{self.seed}.panoptic"
        drifting = self.run("drifting", self.folder, "--map", drifting_map)
        corrected = self.options.out / f"corrected_{self.seed}.panoptic"
        if not corrected.exists():
            call(self.options.panoptic, "rebuild", drifting_map, "--poses", path, "-o", corrected)
        updates = self.options.out / f"updates_{self.seed}.jsonl"
        write_updates(updates, poses, 5)
        on_the_way = self.run("on_the_way", self.folder, "--pose-updates", updates)
        true_home = self.options.out / f"true_home_{self.seed}"
        if not true_home.exists():
            self.simulate(true_home, "kinect")  # the same but for the drift
        truth = self.run("true", true_home)
        return {"drifting": self.scores(drifting), "corrected at the end": self.scores(corrected),
                "corrected on the way": self.scores(on_the_way), "true poses": self.scores(truth)}


def figures(scores):
    surface = next(at for at in scores["surface"]["at"] if abs(at["threshold_m"] - 0.05) < 1e-6)
    return 100 * scores["pq"]["all"], 100 * scores["miou"], 100 * surface["f_score"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("panoptic", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3, 4, 5])
    parser.add_argument("--rooms", type=int, default=3)
    parser.add_argument("--frames", type=int, default=400)
    parser.add_argument("--predictions", default="oracle")
    parser.add_argument("--voxel", type=float, default=0.024)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    print("| home | poses | PQ | mIoU | F-score at 5 cm |\n|---|---|---|---|---|")
    for seed in options.seeds:
        for name, scores in Home(options, seed).rows().items():
            pq, miou, f = figures(scores)
            print(f"| {seed} | {name} | {pq:.1f} | {miou:.1f} | {f:.1f} |", flush=True)


if __name__ == "__main__":
    main()
