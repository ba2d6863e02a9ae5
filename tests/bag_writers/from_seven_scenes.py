# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""from_seven_scenes.py FOLDER FILE.bag|FILE.db3 [FRAMES]: a 7-Scenes recording as a bag, with its images as they are stored. It
gives no CameraInfo: read the bag with the folder's calibration file."""

import struct
import sys
from pathlib import Path

import numpy as np
import writers

STEP_NS = 33_333_333


def quaternion(r):
    """x y z w of a rotation matrix whose camera does not hang upside down all the time: the largest part first."""
    w2, x2, y2, z2 = 1 + np.trace(r), 1 + 2 * r[0, 0] - np.trace(r), 1 + 2 * r[1, 1] - np.trace(r), 1 + 2 * r[2, 2] - np.trace(r)
    largest = int(np.argmax([x2, y2, z2, w2]))
    if largest == 3:
        q = [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], w2]
    elif largest == 0:
        q = [x2, r[0, 1] + r[1, 0], r[0, 2] + r[2, 0], r[2, 1] - r[1, 2]]
    elif largest == 1:
        q = [r[0, 1] + r[1, 0], y2, r[1, 2] + r[2, 1], r[0, 2] - r[2, 0]]
    else:
        q = [r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], z2, r[1, 0] - r[0, 1]]
    return tuple(float(v) for v in np.array(q) / np.linalg.norm(q))


def messages(folder, most):
    for i, path in enumerate(sorted(Path(folder).glob("frame-*.pose.txt"))[:most]):
        time = 10**18 + i * STEP_NS
        name = str(path)[:-len(".pose.txt")]
        matrix = np.loadtxt(path)
        color = next(Path(name + ending) for ending in (".color.jpg", ".color.png") if Path(name + ending).exists())
        depth = {"stamp": time, "frame_id": "depth"}
        yield time, "/depth/image/compressedDepth", "sensor_msgs/CompressedImage", {
            "header": depth, "format": "16UC1; compressedDepth png", "data": struct.pack("<Iff", 0, 0, 0) + Path(name + ".depth.png").read_bytes()}
        yield time, "/color/image/compressed", "sensor_msgs/CompressedImage", {
            "header": {"stamp": time, "frame_id": "color"}, "format": f"rgb8; {color.suffix[1:]} compressed bgr8", "data": color.read_bytes()}
        yield time, "/pose", "geometry_msgs/PoseStamped", {
            "header": {"stamp": time, "frame_id": "map"}, "pose": (tuple(map(float, matrix[:3, 3])), quaternion(matrix[:3, :3]))}


def main():
    folder, output, most = sys.argv[1], sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else None
    (writers.write_db3 if output.endswith(".db3") else writers.write_ros1)(output, messages(folder, most))


if __name__ == "__main__":
    main()
