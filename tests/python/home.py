# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""What the tests share: a small simulated home with predictions, and frames that are made by hand."""
import atexit
import functools
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

import numpy as np

import panoptic as pf

PROGRAM = os.environ.get("PANOPTIC_PROGRAM", "")
SOURCE = pathlib.Path(__file__).resolve().parents[2]
COARSE = {"map": {"voxel_size_m": 0.05}}
LABELS = pf.LabelSet("test", [pf.LabelClass(1, "wall", is_thing=False), pf.LabelClass(2, "floor", is_thing=False),
                              pf.LabelClass(3, "chair"), pf.LabelClass(4, "cup")])
K = np.array([[100.0, 0, 79.5], [0, 100.0, 59.5], [0, 0, 1]])


@functools.cache
def scratch():
    folder = pathlib.Path(tempfile.mkdtemp(prefix="panoptic_python_"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


@functools.cache
def home():
    """The folder of the home: a ScanNet scan, its truth, and predictions."""
    folder = scratch() / "home"
    pf.simulate(folder, seed=3, rooms=1, frames=8, noise="none", truth_stride=8)
    return folder


@functools.cache
def mapped():
    """A finished mapper of the home."""
    options = pf.Options(**COARSE)
    predictor = pf.file_predictor(home() / "predictions")
    mapper = pf.Mapper(options, labels=predictor.labels)
    for frame in pf.open_dataset(home()):
        mapper.add(frame, predictor.predict(frame))
    mapper.finish()
    return mapper


def release_only(why):
    """Leaves a test to the release build, because a sanitizer says nothing more about it."""
    return unittest.skipIf("PANOPTIC_SANITIZED" in os.environ, f"in the release build alone: {why}")


def shared(relative):
    """A file or folder of the shared data; whoever calls is skipped without it, as the C++ tests are."""
    path = pathlib.Path(os.environ.get("PANOPTIC_SHARED", SOURCE.parent / "shared")) / relative
    if not path.exists():
        raise unittest.SkipTest(f"needs {path}; set PANOPTIC_SHARED to its folder")
    return path


def run_program(*arguments):
    """What the program prints. Whoever calls skips without a program."""
    result = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, timeout=120)
    if result.returncode != 0:
        raise AssertionError(f"{arguments}: {result.stderr}")
    return result.stdout


def arrays(i=0, width=160, height=120):
    """A frame of a wall 2 m away, by its arrays; the camera moves along the wall."""
    depth = np.full((height, width), 2.0, np.float32)
    color = np.zeros((height, width, 3), np.uint8)
    color[:, :, 0] = 200
    pose = np.eye(4)
    pose[0, 3] = 0.01 * i
    return dict(depth=depth, color=color, K=K, pose=pose, index=i, time_s=i / 30)


def ids_of(rows=40, width=160, height=120):
    """An id image: a wall, and a chair in the first rows."""
    ids = np.ones((height, width), np.uint16)
    ids[:rows] = 2
    return ids


def small_mapper(**options):
    return pf.Mapper(pf.Options(**(COARSE | options)), labels=LABELS)
