# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Asks a map file where things are, and what is near them.

    03_ask_a_map.py MAP.panoptic CLASS
"""
import sys

import panoptic as pf


def main(path: str, class_name: str) -> None:
    room = pf.load_map(path)
    for item in room.objects(class_name):
        x, y, z = item.center_m
        print(f"{item.class_name} {item.id} is at {x:.2f} {y:.2f} {z:.2f}, seen {item.observations} times")
        for other, distance_m in room.nearest(item.center_m, count=3):
            if other.id != item.id:
                print(f"  {distance_m:.2f} m from {other.class_name} {other.id}")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    try:
        main(*sys.argv[1:])
    except pf.Error as error:
        sys.exit(str(error))
