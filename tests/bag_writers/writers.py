# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Bags by writers that are not ours: Debian's rosbag, Python's sqlite3, and @mcap/core from npm (write_mcap.mjs). What serializes
for ROS 2 follows the rules of CDR."""

import base64
import json
import sqlite3
import struct
import subprocess
from pathlib import Path

HERE = Path(__file__).resolve().parent


class Cdr:
    """Little-endian, or big-endian; numbers lie at multiples of their size."""

    def __init__(self, big=False):
        self.order = ">" if big else "<"
        self.head = b"\0\0\0\0" if big else b"\0\1\0\0"
        self.body = bytearray()

    def put(self, kind, *values):
        size = struct.calcsize("=" + kind)
        for value in values:
            self.body += bytes(-len(self.body) % size) + struct.pack(self.order + kind, value)

    def text(self, value):
        raw = value.encode() + b"\0"
        self.put("I", len(raw))
        self.body += raw

    def blob(self, value):
        self.put("I", len(value))
        self.body += value

    def header(self, fields):
        self.put("i", fields["stamp"] // 10**9)
        self.put("I", fields["stamp"] % 10**9)
        self.text(fields["frame_id"])

    def pose(self, pose):
        for part in pose:
            self.put("d", *part)


def to_cdr(kind, fields, big=False):
    cdr = Cdr(big)
    if kind == "tf2_msgs/TFMessage":
        cdr.put("I", len(fields["transforms"]))
        for transform in fields["transforms"]:
            cdr.header(transform["header"])
            cdr.text(transform["child"])
            cdr.pose(transform["pose"])
        return cdr.head + bytes(cdr.body)
    cdr.header(fields["header"])
    if kind == "sensor_msgs/Image":
        cdr.put("I", fields["height"], fields["width"])
        cdr.text(fields["encoding"])
        cdr.put("B", fields["is_bigendian"])
        cdr.put("I", fields["step"])
        cdr.blob(fields["data"])
    elif kind == "sensor_msgs/CompressedImage":
        cdr.text(fields["format"])
        cdr.blob(fields["data"])
    elif kind == "sensor_msgs/CameraInfo":
        cdr.put("I", fields["height"], fields["width"])
        cdr.text(fields["distortion_model"])
        cdr.put("I", len(fields["d"]))
        cdr.put("d", *fields["d"], *fields["k"], *fields["r"], *fields["p"])
        cdr.put("I", 0, 0, 0, 0, 0, 0)
        cdr.put("B", 0)
    elif kind == "nav_msgs/Odometry":
        cdr.text(fields["child"])
        cdr.pose(fields["pose"])
        cdr.put("d", *[0.0] * (36 + 6 + 36))
    else:
        cdr.pose(fields["pose"])
    return cdr.head + bytes(cdr.body)


def ros2_type(kind):
    return kind.replace("/", "/msg/")


def write_db3(path, messages, big=False):
    with sqlite3.connect(path) as database:
        database.executescript(
            "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT NULL,"
            " offered_qos_profiles TEXT NOT NULL);"
            "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);"
            "CREATE INDEX timestamp_idx ON messages (timestamp ASC);")
        ids = {}
        for time, topic, kind, fields in messages:
            if topic not in ids:
                ids[topic] = len(ids) + 1
                database.execute("INSERT INTO topics VALUES(?, ?, ?, 'cdr', '')", (ids[topic], topic, ros2_type(kind)))
            database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)",
                             (ids[topic], time, to_cdr(kind, fields, big)))
    database.close()


def write_mcap(path, messages, compression="none", indexed=True):
    """False if @mcap/core is not installed."""
    if not (HERE / "node_modules/@mcap/core").is_dir():
        return False
    lines = [json.dumps({"topic": topic, "type": ros2_type(kind), "time": str(time),
                         "data": base64.b64encode(to_cdr(kind, fields)).decode()}) for time, topic, kind, fields in messages]
    subprocess.run(["node", str(HERE / "write_mcap.mjs"), str(path), compression, "indexed" if indexed else "plain"], input="\n".join(lines),
                   text=True, check=True)
    return True


def ros1_message(kind, fields):
    """An object of ROS's own classes."""
    # Debian's python3-rosbag and the messages; whoever calls this has found them.
    import genpy
    from geometry_msgs.msg import PoseStamped, TransformStamped
    from nav_msgs.msg import Odometry
    from sensor_msgs.msg import CameraInfo, CompressedImage, Image
    from tf2_msgs.msg import TFMessage

    def fill_header(header, values):
        header.stamp = genpy.Time(values["stamp"] // 10**9, values["stamp"] % 10**9)
        header.frame_id = values["frame_id"]

    def fill(point, rotation, pose):
        point.x, point.y, point.z = pose[0]
        rotation.x, rotation.y, rotation.z, rotation.w = pose[1]

    if kind == "tf2_msgs/TFMessage":
        message = TFMessage()
        for values in fields["transforms"]:
            transform = TransformStamped(child_frame_id=values["child"])
            fill_header(transform.header, values["header"])
            fill(transform.transform.translation, transform.transform.rotation, values["pose"])
            message.transforms.append(transform)
        return message
    message = {"sensor_msgs/Image": Image, "sensor_msgs/CompressedImage": CompressedImage, "sensor_msgs/CameraInfo": CameraInfo,
               "nav_msgs/Odometry": Odometry, "geometry_msgs/PoseStamped": PoseStamped}[kind]()
    fill_header(message.header, fields["header"])
    if kind == "nav_msgs/Odometry":
        message.child_frame_id = fields["child"]
        fill(message.pose.pose.position, message.pose.pose.orientation, fields["pose"])
    elif kind == "geometry_msgs/PoseStamped":
        fill(message.pose.position, message.pose.orientation, fields["pose"])
    else:
        for name, value in fields.items():
            if name != "header":
                setattr(message, name.upper() if name in ("d", "k", "r", "p") else name, value)
    return message


def has_rosbag():
    try:
        import nav_msgs.msg  # noqa: F401
        import rosbag  # noqa: F401
        import sensor_msgs.msg  # noqa: F401
        import tf2_msgs.msg  # noqa: F401
    except ImportError:
        return False
    return True


def write_ros1(path, messages, compression="none"):
    import genpy
    import rosbag
    with rosbag.Bag(str(path), "w", compression=compression, chunk_threshold=30000) as bag:
        for time, topic, kind, fields in messages:
            bag.write(topic, ros1_message(kind, fields), genpy.Time(time // 10**9, time % 10**9))
