#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""What the tests of a build came to, test by test: ctest knows only the processes that they ran in.

    tools/test_results.py BUILD_FOLDER...

Reads the results that GoogleTest left in BUILD_FOLDER/results."""
import json
import pathlib
import sys

kSlowest = 5


def tests_of(folder):
    for file in sorted(folder.glob("*.json")):
        for suite in json.loads(file.read_text(encoding="utf-8"))["testsuites"]:
            for test in suite["testsuite"]:
                if test["status"] == "RUN":
                    yield f"{suite['name']}.{test['name']}", test


def summary(name, folder):
    tests = list(tests_of(folder))
    failed = [n for n, t in tests if "failures" in t]
    skipped = [n for n, t in tests if t["result"] == "SKIPPED"]
    slowest = sorted(tests, key=lambda test: -float(test[1]["time"].rstrip("s")))[:kSlowest]
    lines = [f"{name}: {len(tests)} tests of GoogleTest, {len(skipped)} skipped, {len(failed)} failed"]
    lines += [f"  failed: {n}" for n in failed] + [f"  skipped: {n}" for n in skipped]
    if slowest:
        lines.append("  slowest: " + ", ".join(f"{n} {float(t['time'].rstrip('s')):.1f} s" for n, t in slowest))
    return lines


def main(*builds):
    for build in builds:
        print("\n".join(summary(pathlib.Path(build).name, pathlib.Path(build) / "results")))


if __name__ == "__main__":
    main(*sys.argv[1:])
