#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""panoptic benchmark --quick is killed after its first part, goes on, reaches its floors, and does nothing twice.

Usage: benchmark_test.py PROGRAM FOLDER"""
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time


def benchmark(program, folder):
    done = subprocess.run([program, "benchmark", "--quick", "-o", folder], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    shutil.rmtree(folder, ignore_errors=True)
    killed = subprocess.Popen([program, "benchmark", "--quick", "-o", folder], stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL, start_new_session=True)
    while killed.poll() is None and not (folder / "parts/0/scene.json").exists():
        time.sleep(0.05)
    time.sleep(1)
    assert killed.poll() is None, "it was to be killed while it works"
    os.killpg(killed.pid, signal.SIGKILL)
    killed.wait()
    assert not (folder / "report.json").exists()
    first = (folder / "parts/0/part.json").stat().st_mtime_ns
    output = benchmark(program, folder)
    print(output)
    parts = len(list(folder.glob("parts/*/part.json")))
    assert f"{parts} parts, 1 of them done before" in output, output
    assert (folder / "parts/0/part.json").stat().st_mtime_ns == first
    report = (folder / "report.json").read_bytes()
    begin = time.monotonic()
    again = benchmark(program, folder)
    assert f"{parts} parts, {parts} of them done before" in again, again
    assert time.monotonic() - begin < 10
    assert (folder / "report.json").read_bytes() == report


if __name__ == "__main__":
    main()
