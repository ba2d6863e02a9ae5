#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Open3D's two TSDF integrators and ours on the same frames, in turns; prints a table of ratios.

Usage: open3d_tsdf.py RECORDING --bench build/release/panoptic-bench [--calibration FILE] [--frames A:B:STEP]
                      [--truth MESH.ply --score build/release/score_surface] [--json FILE]

Needs Debian's python3-open3d. Ours integrates colour and labels, theirs colour alone. panoptic-bench decodes the frames for all.
Theirs take the colour image as it is, although a recording's cameras may stand apart: that costs them no time. Times are those of
integration alone, each frame with its best of all rounds; medians over frames. Memory is that of the map: ours as it counts itself (index and
slack included), of VoxelBlockGrid the blocks in use (what it allocated beforehand is left out), of ScalableTSDFVolume, which does not
say, what the process grew by while it integrated. With --truth the meshes of the last round are
scored by the metrics of `panoptic eval`.
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

import numpy as np  # noqa: E402
import open3d as o3d  # noqa: E402

DEPTH_SCALE = 1000.0
DEPTH_MAX_M = 8.0
BAND_VOXELS = 4.0
BLOCKS = 50000
SEEN_ONCE = 0.0  # least weight of the voxels that enter Open3D's mesh, and its default
SEEN_THRICE = 3.0
THEIRS = "--theirs"  # modes of this script that run in processes of their own
EXTRACT = "--extract"


class Frames:
    """What panoptic-bench --raw-frames writes: depth in millimetres, colour, and camera_from_world of each frame."""

    def __init__(self, folder):
        description = json.loads((folder / "frames.json").read_text(encoding="utf-8"))
        self.camera = camera = description["depth_camera"]
        color = description["color_camera"]
        if (color["width"], color["height"]) != (camera["width"], camera["height"]):
            raise OSError(f"{folder}: depth and colour differ in size, which Open3D does not take")
        shape = (-1, camera["height"], camera["width"])
        self.depth = np.fromfile(folder / "depth.u16", np.uint16).reshape(shape)
        self.color = np.fromfile(folder / "color.rgb", np.uint8).reshape(*shape, 3)
        self.extrinsic = [np.linalg.inv(np.reshape(pose, (4, 4))) for pose in description["world_from_camera"]]

    def __len__(self):
        return len(self.extrinsic)


def rss_mb():
    pages = int(pathlib.Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def grid_mb(grid):
    """Of the blocks in use: distance, weight and colour of each voxel are floats."""
    return grid.hashmap().size() * 16 ** 3 * 5 * 4 / 1e6


def timed(work):
    start = time.perf_counter()
    work()
    return (time.perf_counter() - start) * 1e3


def voxel_block_grid(frames, voxel_m):
    tensor, c = o3d.core.Tensor, frames.camera
    intrinsic = tensor([[c["fx"], 0, c["cx"]], [0, c["fy"], c["cy"]], [0, 0, 1]], o3d.core.float64)
    grid = o3d.t.geometry.VoxelBlockGrid(("tsdf", "weight", "color"), (o3d.core.float32,) * 3, ((1), (1), (3)), voxel_m, 16,
                                         BLOCKS, o3d.core.Device("CPU:0"))

    def integrate(depth, color, pose):
        blocks = grid.compute_unique_block_coordinates(depth, intrinsic, pose, DEPTH_SCALE, DEPTH_MAX_M, BAND_VOXELS)
        grid.integrate(blocks, depth, color, intrinsic, intrinsic, pose, DEPTH_SCALE, DEPTH_MAX_M, BAND_VOXELS)

    times = []
    for i in range(len(frames)):
        depth, color = o3d.t.geometry.Image(frames.depth[i]), o3d.t.geometry.Image(frames.color[i])
        pose = tensor(frames.extrinsic[i])
        times.append(timed(lambda: integrate(depth, color, pose)))
    return times, grid


def scalable_volume(frames, voxel_m):
    volume = o3d.pipelines.integration.ScalableTSDFVolume(
        voxel_m, BAND_VOXELS * voxel_m, o3d.pipelines.integration.TSDFVolumeColorType.RGB8)
    c = frames.camera
    intrinsic = o3d.camera.PinholeCameraIntrinsic(c["width"], c["height"], c["fx"], c["fy"], c["cx"], c["cy"])
    times = []
    for i in range(len(frames)):
        image = o3d.geometry.RGBDImage.create_from_color_and_depth(
            o3d.geometry.Image(frames.color[i]), o3d.geometry.Image(frames.depth[i]), DEPTH_SCALE, DEPTH_MAX_M,
            convert_rgb_to_intensity=False)
        times.append(timed(lambda: volume.integrate(image, intrinsic, frames.extrinsic[i])))
    return times, volume


def bench(arguments, *more):
    command = [arguments.bench, arguments.recording, "--frames", arguments.frames, *more]
    command += ["--calibration", arguments.calibration] if arguments.calibration else []
    subprocess.run([str(part) for part in command], check=True, stdout=subprocess.DEVNULL)


def ours(arguments, voxel_m, scratch):
    bench(arguments, "--repeat", "1", "--json", scratch / "bench.json", "--mesh", scratch / "ours.ply", "--set", f"map.voxel_size_m={voxel_m}")
    return json.loads((scratch / "bench.json").read_text(encoding="utf-8"))


def write_ply(path, positions, triangles):
    faces = np.empty(len(triangles), dtype=[("count", "u1"), ("vertices", "<i4", 3)])
    faces["count"], faces["vertices"] = 3, triangles
    header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(positions)}\nproperty float x\nproperty float y\nproperty float z\n"
              f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")
    path.write_bytes(header.encode() + np.ascontiguousarray(positions, "<f4").tobytes() + faces.tobytes())


def score(arguments, mesh):
    result = subprocess.run([arguments.score, mesh, arguments.truth], check=True, capture_output=True, text=True)
    return json.loads(result.stdout)


def surfaces(arguments, scratch):
    """Scores of the three meshes. Open3D's grid has a threshold of its own for what enters the mesh: the better one counts."""
    scores = {"ours": score(arguments, scratch / "ours.ply"), "volume": score(arguments, scratch / "volume.ply")}
    for weight in (SEEN_ONCE, SEEN_THRICE):
        # In a process of its own: on some maps Open3D 0.16 ends the whole program with a failed assertion here.
        extraction = again(EXTRACT, scratch / "grid.npz", weight, scratch / "grid.ply", capture_output=True)
        name = f"grid, weight over {weight:g}"
        if extraction.returncode == 0:
            scores[name] = score(arguments, scratch / "grid.ply")
        else:
            print(f"open3d_tsdf: Open3D could not extract the mesh of {name}", file=sys.stderr)
    return scores


def again(mode, *arguments, **options):
    """This script in another mode, as a process of its own."""
    return subprocess.run([sys.executable, __file__, mode, *(str(a) for a in arguments)], **options)


def extract(grid_file, weight, mesh_file):
    mesh = o3d.t.geometry.VoxelBlockGrid.load(grid_file).extract_triangle_mesh(float(weight))
    write_ply(pathlib.Path(mesh_file), mesh.vertex["positions"].numpy(), mesh.triangle["indices"].numpy())


def theirs(scratch, voxel_m, with_meshes):
    """One round of Open3D's two: times and surfaces go to files."""
    scratch = pathlib.Path(scratch)
    frames = Frames(scratch / "raw")
    grid_ms, grid = voxel_block_grid(frames, float(voxel_m))
    before_mb = rss_mb()
    volume_ms, volume = scalable_volume(frames, float(voxel_m))
    measured = {"grid_ms": grid_ms, "volume_ms": volume_ms, "grid_mb": grid_mb(grid), "volume_mb": rss_mb() - before_mb}
    (scratch / "theirs.json").write_text(json.dumps(measured), encoding="utf-8")
    if not with_meshes:
        return
    mesh = volume.extract_triangle_mesh()
    write_ply(scratch / "volume.ply", np.asarray(mesh.vertices), np.asarray(mesh.triangles))
    grid.save(str(scratch / "grid.npz"))


def compared(arguments, voxel_m, scratch):
    our_p50, grid_ms, volume_ms = [], [], []
    for done in range(arguments.rounds):
        our_result = ours(arguments, voxel_m, scratch)
        our_p50.append(our_result["stages"]["integrate"]["p50_ms"])
        # At its best: passive waiting costs it a factor of 2 to 3. In a process of its own, because threads that wait actively keep
        # a core busy as long as they live, which would halve our speed.
        with_meshes = "meshes" if arguments.truth and done == arguments.rounds - 1 else ""
        again(THEIRS, scratch, voxel_m, with_meshes, check=True, env={**os.environ, "OMP_WAIT_POLICY": "active"})
        times = json.loads((scratch / "theirs.json").read_text(encoding="utf-8"))
        grid_ms.append(times["grid_ms"])
        volume_ms.append(times["volume_ms"])
    row = {"voxel_m": voxel_m, "ours_ms": min(our_p50), "grid_ms": statistics.median(np.min(grid_ms, axis=0)),
           "volume_ms": statistics.median(np.min(volume_ms, axis=0)), "ours_mb": our_result["map_mb"], "grid_mb": times["grid_mb"],
           "volume_mb": times["volume_mb"]}
    row["ratio"] = min(row["grid_ms"], row["volume_ms"]) / row["ours_ms"]
    if arguments.truth:
        row["surface"] = surfaces(arguments, scratch)
    return row


def parsed_arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("recording")
    parser.add_argument("--bench", required=True)
    parser.add_argument("--calibration")
    parser.add_argument("--frames", default="0:500:5")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--voxels", default="0.024,0.01", help="voxel sizes in metres, default 0.024,0.01")
    parser.add_argument("--truth", help="the true surface, a PLY mesh: the meshes are scored, too")
    parser.add_argument("--score", help="the program score_surface, for --truth")
    parser.add_argument("--json", type=pathlib.Path)
    arguments = parser.parse_args()
    if arguments.truth and not arguments.score:
        parser.error("--truth needs --score")
    return arguments


def main():
    arguments = parsed_arguments()
    with tempfile.TemporaryDirectory() as folder:
        scratch = pathlib.Path(folder)
        bench(arguments, "--raw-frames", scratch / "raw")
        frames = Frames(scratch / "raw")
        rows = [compared(arguments, float(voxel_m), scratch) for voxel_m in arguments.voxels.split(",")]
    result = {"open3d": o3d.__version__, "frames": len(frames), "cores": os.cpu_count(), "rows": rows}
    if arguments.json:
        arguments.json.write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8")
    print(f"Open3D {o3d.__version__}, {len(frames)} frames, {os.cpu_count()} cores")
    for row in rows:
        print(f"{row['voxel_m'] * 100:g} cm: ours, with labels {row['ours_ms']:.2f} ms, VoxelBlockGrid {row['grid_ms']:.2f} ms, "
              f"ScalableTSDFVolume {row['volume_ms']:.2f} ms, ratio to the faster {row['ratio']:.1f}; "
              f"map {row['ours_mb']:.0f}, {row['grid_mb']:.0f} and {row['volume_mb']:.0f} MB")
        for name, scores in row.get("surface", {}).items():
            f5, f2 = (t["f_score"] * 100 for t in scores["at"])
            print(f"  {name}: F {f5:.2f} at 5 cm, {f2:.2f} at 2.5 cm; accuracy {scores['accuracy_m'] * 1e3:.2f} mm, "
                  f"completion {scores['completion_m'] * 1e3:.2f} mm")


if __name__ == "__main__":
    try:
        if sys.argv[1:2] == [THEIRS]:
            theirs(*sys.argv[2:])
        elif sys.argv[1:2] == [EXTRACT]:
            extract(*sys.argv[2:])
        else:
            main()
    except (subprocess.CalledProcessError, OSError) as failure:
        sys.exit(f"open3d_tsdf: {failure}")
