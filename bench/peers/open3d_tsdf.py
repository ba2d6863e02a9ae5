#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Open3D's two TSDF integrators and ours on the same frames of a 7-Scenes recording, in turns; prints a table of ratios.

Usage: open3d_tsdf.py RECORDING --bench build/release/panoptic-bench [--calibration FILE] [--frames A:B:STEP]

Needs Debian's python3-open3d. Ours integrates colour and labels, theirs colour alone. Theirs take the colour image as it is,
although the recording's cameras stand apart: that costs them no time. Times are those of integration alone, frames decoded
beforehand, each frame with its best of all rounds; medians over frames.
"""
import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

os.environ.setdefault("OMP_WAIT_POLICY", "active")  # before Open3D loads: passive waiting costs it a factor of 2 to 3

import numpy as np  # noqa: E402
import open3d as o3d  # noqa: E402

DEPTH_SCALE = 1000.0
DEPTH_MAX_M = 8.0
BAND_VOXELS = 4.0
FOCAL_PX = 585.0  # of 7-Scenes' depth camera; its principal point is the middle of 640 x 480
WIDTH, HEIGHT = 640, 480


def frames_of(folder, text):
    begin, end, step = (int(part) for part in (text.split(":") + ["1"])[:3])
    result = []
    for i in range(begin, end, step):
        stem = folder / f"frame-{i:06d}"
        depth = np.asarray(o3d.io.read_image(f"{stem}.depth.png")).copy()
        depth[depth == 65535] = 0
        color = np.asarray(o3d.io.read_image(f"{stem}.color.jpg")).copy()
        result.append((depth, color, np.linalg.inv(np.loadtxt(f"{stem}.pose.txt"))))
    return result


def voxel_block_grid(frames, voxel_m):
    tensor = o3d.core.Tensor
    intrinsic = tensor([[FOCAL_PX, 0, WIDTH / 2], [0, FOCAL_PX, HEIGHT / 2], [0, 0, 1]], o3d.core.float64)
    grid = o3d.t.geometry.VoxelBlockGrid(("tsdf", "weight", "color"), (o3d.core.float32,) * 3, ((1), (1), (3)), voxel_m, 16,
                                         50000, o3d.core.Device("CPU:0"))
    images = [(o3d.t.geometry.Image(depth), o3d.t.geometry.Image(color), tensor(pose)) for depth, color, pose in frames]
    times = []
    for depth, color, extrinsic in images:
        start = time.perf_counter()
        blocks = grid.compute_unique_block_coordinates(depth, intrinsic, extrinsic, DEPTH_SCALE, DEPTH_MAX_M, BAND_VOXELS)
        grid.integrate(blocks, depth, color, intrinsic, intrinsic, extrinsic, DEPTH_SCALE, DEPTH_MAX_M, BAND_VOXELS)
        times.append((time.perf_counter() - start) * 1e3)
    return times


def scalable_volume(frames, voxel_m):
    volume = o3d.pipelines.integration.ScalableTSDFVolume(
        voxel_m, BAND_VOXELS * voxel_m, o3d.pipelines.integration.TSDFVolumeColorType.RGB8)
    intrinsic = o3d.camera.PinholeCameraIntrinsic(WIDTH, HEIGHT, FOCAL_PX, FOCAL_PX, WIDTH / 2, HEIGHT / 2)
    times = []
    for depth, color, extrinsic in frames:
        image = o3d.geometry.RGBDImage.create_from_color_and_depth(
            o3d.geometry.Image(color), o3d.geometry.Image(depth), DEPTH_SCALE, DEPTH_MAX_M, convert_rgb_to_intensity=False)
        start = time.perf_counter()
        volume.integrate(image, intrinsic, extrinsic)
        times.append((time.perf_counter() - start) * 1e3)
    return times


def ours(arguments, voxel_m):
    with tempfile.TemporaryDirectory() as scratch:
        result = pathlib.Path(scratch) / "bench.json"
        command = [arguments.bench, arguments.recording, "--frames", arguments.frames, "--repeat", "1", "--json", result]
        command += ["--calibration", arguments.calibration] if arguments.calibration else []
        command += ["--set", f"map.voxel_size_m={voxel_m}"]
        subprocess.run([str(part) for part in command], check=True, stdout=subprocess.DEVNULL)
        return json.loads(result.read_text(encoding="utf-8"))["stages"]["integrate"]["p50_ms"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("recording", type=pathlib.Path)
    parser.add_argument("--bench", required=True)
    parser.add_argument("--calibration")
    parser.add_argument("--frames", default="0:500:5")
    parser.add_argument("--rounds", type=int, default=3)
    arguments = parser.parse_args()
    frames = frames_of(arguments.recording, arguments.frames)
    print(f"Open3D {o3d.__version__}, {len(frames)} frames, {os.cpu_count()} cores")
    print("| voxel | ours, with labels (ms) | VoxelBlockGrid (ms) | ScalableTSDFVolume (ms) | ratio to the faster |")
    print("|---|---|---|---|---|")
    for voxel_m in (0.024, 0.01):
        our_p50, grid, volume = [], [], []
        for _ in range(arguments.rounds):
            our_p50.append(ours(arguments, voxel_m))
            grid.append(voxel_block_grid(frames, voxel_m))
            volume.append(scalable_volume(frames, voxel_m))
        grid_ms = statistics.median(np.min(grid, axis=0))
        volume_ms = statistics.median(np.min(volume, axis=0))
        best = min(our_p50)
        print(f"| {voxel_m * 100:g} cm | {best:.2f} | {grid_ms:.2f} | {volume_ms:.2f} | {min(grid_ms, volume_ms) / best:.1f} |",
              flush=True)


if __name__ == "__main__":
    try:
        main()
    except (subprocess.CalledProcessError, OSError) as failure:
        sys.exit(f"open3d_tsdf: {failure}")
