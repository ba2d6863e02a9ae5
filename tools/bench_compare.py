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
import os
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
    run(["git", "-C", ROOT, "worktree", "prune"])
    if not (folder / "CMakeLists.txt").exists():
        run(["git", "-C", ROOT, "worktree", "add", "--quiet", "--force", "--detach", folder, commit])
    third_party = folder / "third_party"
    if not third_party.exists() and (ROOT / "third_party").exists():
        third_party.symlink_to(ROOT / "third_party")
    options = ["-DPANOPTIC_TESTS=OFF", "-DPANOPTIC_EXAMPLES=OFF", "-Wno-dev"]
    shared_cache = {**os.environ, "CCACHE_BASEDIR": str(folder)}  # so that what both commits have is compiled once
    print(f"building {commit[:12]}", file=sys.stderr)
    run(["cmake", "--preset", "release", *options], cwd=folder, capture_output=True, env=shared_cache)
    run(["cmake", "--build", "--preset", "release", "--target", "panoptic-bench"], cwd=folder, capture_output=True, env=shared_cache)
    return folder / "build/release/panoptic-bench"


def measure(program, arguments):
    with tempfile.TemporaryDirectory() as scratch:
        result = pathlib.Path(scratch) / "bench.json"
        command = [program, arguments.recording, "--json", result, "--repeat", arguments.repeat, "--threads", arguments.threads]
        command += ["--frames", arguments.frames]
        command += ["--calibration", arguments.calibration] if arguments.calibration else []
        for assignment in arguments.set:
            command += ["--set", assignment]
        run(command, capture_output=True)
        return json.loads(result.read_text(encoding="utf-8"))


def compared(base_runs, head_runs):
    """{stage: (base ms, head ms, change in percent, spread of the base in percent)} of the stages that both have. A stage counts
    with its smallest median: noise of the machine only ever adds."""
    rows = {}
    for stage in sorted(base_runs[0]["stages"].keys() & head_runs[0]["stages"].keys()):
        base, head = ([r["stages"][stage]["p50_ms"] for r in runs] for runs in (base_runs, head_runs))
        least = min(base)
        if least > 0:  # a median of nothing cannot grow
            rows[stage] = (least, min(head), (min(head) / least - 1) * 100, statistics.pstdev(base) / least * 100)
    return rows


def verdict(rows, limit):
    """Why the head fails, or nothing."""
    growth = rows[GUARDED][2]
    return f"{GUARDED} grew by {growth:.1f} %, more than {limit:g} %" if growth > limit else None


def report(rows, same_map):
    lines = [f"{'stage':<18}{'base ms':>10}{'head ms':>10}{'change':>9}{'spread':>9}"]
    lines += [f"{stage:<18}{base:>10.3f}{head:>10.3f}{change:>+8.1f}%{spread:>8.1f}%"
              for stage, (base, head, change, spread) in rows.items()]
    return "\n".join(lines + ["same map" if same_map else "the maps differ"])


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
    runs = {side: [] for side in commits}
    for _ in range(arguments.rounds):
        for side, program in programs.items():
            runs[side].append(measure(program, arguments))
    hashes = [{r["map_hash"] for r in side} for side in runs.values()]
    rows = compared(runs["base"], runs["head"])
    print(report(rows, hashes[0] == hashes[1]))
    why = verdict(rows, arguments.limit)
    if why:
        sys.exit(f"bench_compare: {why}")


if __name__ == "__main__":
    try:
        main()
    except subprocess.CalledProcessError as failure:
        last = ((failure.stderr or "") + (failure.stdout or "")).strip().splitlines()[-1:]
        sys.exit(f"bench_compare: {' '.join(failure.cmd)} failed with status {failure.returncode}: {' '.join(last)}")
