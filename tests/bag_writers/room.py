# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""A small room that a camera looks around in: as a TUM RGB-D folder, and as the messages of a bag."""

import math
import struct
import zlib
from pathlib import Path

import numpy as np

WIDTH, HEIGHT, FOCAL = 64, 48, 55.0
FRAMES = 12
STEP_NS = 40_000_000
BEGIN_NS = 1_000_000_000_000
CAMERA = "camera_depth_optical_frame"


def png(pixels):
    """8-bit RGB or 16-bit grey."""
    kind, depth = (2, 8) if pixels.ndim == 3 else (0, 16)
    rows = pixels if depth == 8 else pixels.astype(">u2")
    raw = b"".join(b"\0" + row.tobytes() for row in rows)

    def part(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    head = struct.pack(">IIBBBBB", pixels.shape[1], pixels.shape[0], depth, kind, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + part(b"IHDR", head) + part(b"IDAT", zlib.compress(raw, 1)) + part(b"IEND", b"")


def pose(i):
    """Position, and quaternion x y z w: the camera turns about its y axis and moves a little."""
    angle = 0.06 * i
    return (0.04 * i, 0.01 * i, 0.02 * i), (0.0, math.sin(angle / 2), 0.0, math.cos(angle / 2))


def images(i):
    """Depth in millimetres and colour of a box of 4 x 2.4 x 4 metres around the first camera."""
    (x, y, z), (_, qy, _, qw) = pose(i)
    sine, cosine = 2 * qy * qw, qw * qw - qy * qy
    u, v = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    dx, dy, dz = (u - (WIDTH - 1) / 2) / FOCAL, (v - (HEIGHT - 1) / 2) / FOCAL, np.ones((HEIGHT, WIDTH))
    rays = (cosine * dx + sine * dz, dy, cosine * dz - sine * dx)
    depth = np.full((HEIGHT, WIDTH), np.inf)
    for origin, ray, half in zip((x, y, z), rays, (2.0, 1.2, 2.0)):
        with np.errstate(divide="ignore"):
            wall = np.where(ray > 0, (half - origin) / ray, (-half - origin) / ray)
        depth = np.minimum(depth, np.where(wall > 0, wall, np.inf))
    points = [origin + ray * depth for origin, ray in zip((x, y, z), rays)]
    color = np.stack([np.clip(128 + 50 * p + 20 * np.sin(9 * p), 0, 255) for p in points], axis=2)
    return np.round(depth * 1000).astype(np.uint16), color.astype(np.uint8)


def time_ns(i):
    return BEGIN_NS + i * STEP_NS


def write_tum(folder, pose_shift_ns=0):
    """The folder, and a calibration file beside it. Poses may be of later times than the images."""
    folder = Path(folder)
    lists = {"rgb": [], "depth": []}
    poses = []
    for i in range(FRAMES):
        depth, color = images(i)
        stamp = f"{time_ns(i) // 10**9}.{time_ns(i) % 10**9:09}"
        for name, pixels in (("rgb", color), ("depth", depth)):
            (folder / name).mkdir(parents=True, exist_ok=True)
            (folder / name / f"{stamp}.png").write_bytes(png(pixels))
            lists[name].append(f"{stamp} {name}/{stamp}.png\n")
        numbers = " ".join(f"{value:.17g}" for part in pose(i) for value in part)
        pose_ns = time_ns(i) + pose_shift_ns
        poses.append(f"{pose_ns // 10**9}.{pose_ns % 10**9:09} {numbers}\n")
    for name, lines in lists.items():
        (folder / f"{name}.txt").write_text("".join(lines))
    (folder / "groundtruth.txt").write_text("".join(poses))
    calibration = folder.parent / "room.toml"
    calibration.write_text(f"[depth]\nfx = {FOCAL}\nfy = {FOCAL}\ncx = {(WIDTH - 1) / 2}\ncy = {(HEIGHT - 1) / 2}\n"
                           f"width = {WIDTH}\nheight = {HEIGHT}\nscale = 1000.0\ndistortion = []\n")
    return calibration


def header(i, frame):
    return {"stamp": time_ns(i), "frame_id": frame}


def image(i, frame, encoding, pixels):
    return {"header": header(i, frame), "height": HEIGHT, "width": WIDTH, "encoding": encoding, "is_bigendian": 0,
            "step": pixels.strides[0], "data": pixels.tobytes()}


def depth_message(i, kind, frame):
    depth, _ = images(i)
    if kind == "compressedDepth":
        data = {"header": header(i, frame), "format": "16UC1; compressedDepth", "data": bytes(12) + png(depth)}
        return "/camera/depth/image/compressedDepth", "sensor_msgs/CompressedImage", data
    if kind == "32FC1":
        depth = depth.astype(np.float32) * np.float32(1 / 1000)
    return "/camera/depth/image", "sensor_msgs/Image", image(i, frame, kind, np.ascontiguousarray(depth))


def color_message(i, kind, frame):
    _, color = images(i)
    if kind == "png":
        data = {"header": header(i, frame), "format": "rgb8; png compressed bgr8", "data": png(color)}
        return "/camera/rgb/image/compressed", "sensor_msgs/CompressedImage", data
    if kind.startswith("bgr"):
        color = color[:, :, ::-1]
    if "a8" in kind:
        color = np.dstack([color, np.full(color.shape[:2], 255, np.uint8)])
    return "/camera/rgb/image", "sensor_msgs/Image", image(i, frame, kind, np.ascontiguousarray(color))


def info_message(i, frame):
    k = [FOCAL, 0.0, (WIDTH - 1) / 2, 0.0, FOCAL, (HEIGHT - 1) / 2, 0.0, 0.0, 1.0]
    return {"header": header(i, frame), "height": HEIGHT, "width": WIDTH, "distortion_model": "plumb_bob", "d": [0.0] * 5, "k": k,
            "r": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], "p": [*k[:3], 0.0, *k[3:6], 0.0, *k[6:], 0.0]}


def pose_message(i, kind, frame):
    position, rotation = pose(i)
    if kind == "tf":
        return "/tf", "tf2_msgs/TFMessage", {"transforms": [{"header": header(i, "map"), "child": frame, "pose": (position, rotation)}]}
    if kind == "odometry":
        return "/odometry", "nav_msgs/Odometry", {"header": header(i, "map"), "child": frame, "pose": (position, rotation)}
    return "/pose", "geometry_msgs/PoseStamped", {"header": header(i, "map"), "pose": (position, rotation)}


def messages(depth="16UC1", color="rgb8", poses="tf", frame=CAMERA):
    """Of (time in nanoseconds, topic, type, fields), by time."""
    result = []
    for i in range(FRAMES):
        for topic, kind, fields in (depth_message(i, depth, frame), color_message(i, color, frame), pose_message(i, poses, frame)):
            result.append((time_ns(i), topic, kind, fields))
        for camera in ("depth", "rgb"):
            result.append((time_ns(i), f"/camera/{camera}/camera_info", "sensor_msgs/CameraInfo", info_message(i, frame)))
    return result
