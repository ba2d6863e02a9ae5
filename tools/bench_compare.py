#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Is this commit slower than that one? Builds both in worktrees of their own, runs panoptic-bench of both in turns, and fails
if the fusion side's CPU time grew by more than the limit.

Usage: bench_compare.py RECORDING [--base REV] [--head REV] [--calibration FILE] [--frames A:B:STEP] [--set KEY=VALUE]...

CPU time in turns, not wall time one after the other: what else runs on the machine then weighs alike on both.
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
GUARDED = "fusion_cpu"


def run(command, **options):
    return subprocess.run([str(part) for part in command], check=True, text=True, **options)


def revision(name):
    return run(["git", "-C", ROOT, "rev-parse", "--verify", f"{name}^{{commit}}"], capture_output=True).stdout.strip()


def build(commit, folder):
    """A worktree at the commit with panoptic-bench built in it; kept, so that the next comparison starts warm."""
    if not folder.exists():
        run(["git", "-C", ROOT, "worktree", "add", "--quiet", "--detach", folder, commit])
    third_party = folder / "third_party"
    if not third_party.exists() and (ROOT / "third_party").exists():
        third_party.symlink_to(ROOT / "third_party")
    options = ["-DPANOPTIC_TESTS=OFF", "-DPANOPTIC_EXAMPLES=OFF", "-Wno-dev"]
    run(["cmake", "--preset", "release", *options], cwd=folder, stdout=subprocess.DEVNULL)
    run(["cmake", "--build", "--preset", "release", "--target", "panoptic-bench"], cwd=folder, stdout=subprocess.DEVNULL)
    return folder / "build/release/panoptic-bench"


def measure(program, arguments):
    with tempfile.TemporaryDirectory() as scratch:
        result = pathlib.Path(scratch) / "bench.json"
        command = [program, arguments.recording, "--json", result, "--repeat", arguments.repeat, "--threads", arguments.threads]
        command += ["--frames", arguments.frames]
        command += ["--calibration", arguments.calibration] if arguments.calibration else []
        for assignment in arguments.set:
            command += ["--set", assignment]
        run(command, stdout=subprocess.DEVNULL)
        return json.loads(result.read_text(encoding="utf-8"))


def parsed_arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("recording")
    parser.add_argument("--base", default="HEAD~1")
    parser.add_argument("--head", default="HEAD")
    parser.add_argument("--calibration")
    parser.add_argument("--frames", default="0:500:5")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--rounds", type=int, default=5, help="turns; each stage counts with its smallest median")
    parser.add_argument("--repeat", type=int, default=2)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--limit", type=float, default=5, help="percent of CPU time that the head may cost more")
    return parser.parse_args()


def main():
    arguments = parsed_arguments()
    commits = {"base": revision(arguments.base), "head": revision(arguments.head)}
    programs = {side: build(commit, ROOT / "build/compare" / commit[:12]) for side, commit in commits.items()}
    medians = {side: {} for side in commits}
    hashes = {side: set() for side in commits}
    for _ in range(arguments.rounds):
        for side, program in programs.items():
            result = measure(program, arguments)
            hashes[side].add(result["map_hash"])
            for stage, times in result["stages"].items():
                medians[side].setdefault(stage, []).append(times["p50_ms"])
    print(f"{'stage':<18}{'base ms':>10}{'head ms':>10}{'change':>9}{'spread':>9}")
    for stage in sorted(medians["base"].keys() & medians["head"].keys()):
        base, head = min(medians["base"][stage]), min(medians["head"][stage])
        spread = statistics.pstdev(medians["base"][stage]) / base * 100
        print(f"{stage:<18}{base:>10.3f}{head:>10.3f}{(head / base - 1) * 100:>+8.1f}%{spread:>8.1f}%")
    print("same map" if hashes["base"] == hashes["head"] else "the maps differ")
    growth = (min(medians["head"][GUARDED]) / min(medians["base"][GUARDED]) - 1) * 100
    if growth > arguments.limit:
        sys.exit(f"bench_compare: {GUARDED} grew by {growth:.1f} %, more than {arguments.limit:g} %")


if __name__ == "__main__":
    try:
        main()
    except subprocess.CalledProcessError as failure:
        sys.exit(f"bench_compare: {' '.join(failure.cmd)} failed with status {failure.returncode}; {(failure.stderr or '').strip()}")
