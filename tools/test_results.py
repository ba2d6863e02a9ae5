#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""What the tests of a build came to, test by test: ctest knows only the processes that they ran in.

    tools/test_results.py BUILD_FOLDER...

Reads the results that GoogleTest left in BUILD_FOLDER/results, and in BUILD_FOLDER/results_beside_others where what failed was run
once more. Failures come last, with the first lines of what they say."""
import json
import pathlib
import sys

kSlowest = 5
kLinesOfAFailure = 8


def tests_of(folder):
    for file in sorted(folder.glob("*.json")):
        for suite in json.loads(file.read_text(encoding="utf-8"))["testsuites"]:
            for test in suite["testsuite"]:
                if test["status"] == "RUN":
                    yield f"{suite['name']}.{test['name']}", test


def seconds(test):
    return float(test["time"].rstrip("s"))


def summary(build):
    tests = list(tests_of(build / "results"))
    failed = [n for n, t in tests if "failures" in t]
    skipped = [n for n, t in tests if t["result"] == "SKIPPED"]
    slowest = sorted(tests, key=lambda test: -seconds(test[1]))[:kSlowest]
    lines = [f"{build.name}: {len(tests)} tests of GoogleTest, {len(skipped)} skipped, {len(failed)} failed"]
    lines += [f"  skipped: {n}" for n in skipped]
    if slowest:
        lines.append("  slowest: " + ", ".join(f"{n} {seconds(t):.1f} s" for n, t in slowest))
    return lines


def failures(folder, name):
    for test_name, test in tests_of(folder):
        for failure in test.get("failures", []):
            yield f"{name}: FAILED {test_name}"
            yield from (f"    {line}" for line in failure["failure"].splitlines()[:kLinesOfAFailure])


def main(*names):
    builds = [pathlib.Path(name) for name in names]
    for build in builds:
        print("\n".join(summary(build)))
    for build in builds:
        for line in failures(build / "results_beside_others", f"{build.name}, beside other tests"):
            print(line)
        for line in failures(build / "results", build.name):
            print(line)


if __name__ == "__main__":
    main(*sys.argv[1:])
