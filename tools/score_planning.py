#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Scores seats, table tops, doors and rooms of a plan against the truth of a simulated home, by the rules of docs/home_plan.md.

Usage: score_planning.py TRUTH PLAN [TRUTH PLAN ...] [--turned YAW]

TRUTH is a folder that `panoptic simulate` wrote, PLAN one that `panoptic plan` wrote. --turned: the recording's world was turned by so many
degrees about the vertical before it was mapped, as a list with a place does (docs/datasets.md)."""
import json
import math
import pathlib
import sys

SEAT_M = 0.25
FACING_DEG = 20
TABLE_IOU = 0.5
DOOR_M = 0.3
WIDTH_M = 0.15
ROOM_IOU = 0.75
ROWS = 1000


def crossings(polygon, y):
    at = []
    for (ax, ay), (bx, by) in zip(polygon, polygon[1:] + polygon[:1]):
        if (ay <= y) != (by <= y):
            at.append(ax + (bx - ax) * (y - ay) / (by - ay))
    return sorted(at)


def overlap(a, b):
    return sum(max(0.0, min(a[i + 1], b[j + 1]) - max(a[i], b[j])) for i in range(0, len(a) - 1, 2) for j in range(0, len(b) - 1, 2))


def iou(a, b):
    """Exact along x, in ROWS steps along y."""
    low = min(p[1] for p in a + b)
    high = max(p[1] for p in a + b)
    both = either = 0.0
    for row in range(ROWS):
        y = low + (high - low) * (row + 0.5) / ROWS
        in_a, in_b = crossings(a, y), crossings(b, y)
        common = overlap(in_a, in_b)
        both += common
        either += overlap(in_a, [-1e9, 1e9]) + overlap(in_b, [-1e9, 1e9]) - common
    return both / either if either > 0 else 0.0


def pairs(found, wanted, cost, most):
    """One-to-one pairs, the cheapest first, none dearer than `most`."""
    candidates = sorted((cost(f, w), i, j) for i, f in enumerate(found) for j, w in enumerate(wanted))
    taken_found, taken_wanted, result = set(), set(), []
    for c, i, j in candidates:
        if c <= most and i not in taken_found and j not in taken_wanted:
            taken_found.add(i)
            taken_wanted.add(j)
            result.append((found[i], wanted[j], c))
    return result


def moved(matrix, point):
    x, y, z = (list(point) + [0.0])[:3]
    return [row[0] * x + row[1] * y + row[2] * z + row[3] for row in matrix[:3]]


def turned(matrix, vector):
    origin = moved(matrix, [0, 0, 0])
    return [a - b for a, b in zip(moved(matrix, vector), origin)]


def middle(polygon):
    return [sum(p[axis] for p in polygon) / len(polygon) for axis in range(2)]


def from_above(matrix, polygon):
    return [tuple(moved(matrix, p)[:2]) for p in polygon]


def distance(a, b):
    return math.hypot(a[0] - b[0], a[1] - b[1])


def degrees_between(a, b):
    cosine = (a[0] * b[0] + a[1] * b[1]) / (math.hypot(a[0], a[1]) * math.hypot(b[0], b[1]))
    return math.degrees(math.acos(max(-1.0, min(1.0, cosine))))


def read(folder, ending, undo):
    """Lists of a plan or a truth, in the axes of the simulation."""
    folder = pathlib.Path(folder)
    plan = json.loads((folder / f"affordances{ending}.json").read_text(encoding="utf-8"))
    rooms = json.loads((folder / f"rooms{ending}.json").read_text(encoding="utf-8"))
    grid = plan["world_from_grid"]
    matrix = [[sum(undo[r][k] * grid[k][c] for k in range(4)) for c in range(4)] for r in range(4)]
    return {
        "seats": [{"at": moved(matrix, s["position"]), "facing": turned(matrix, s["facing"])} for s in plan["seats"]],
        "table tops": [{"polygon": from_above(matrix, t["polygon"])} for t in plan["table_tops"]],
        "doors": [{"at": middle(from_above(matrix, d["polygon"])), "width_m": d["width_m"], "open": d["open"]} for d in plan["doors"]],
        "rooms": [{"polygon": from_above(matrix, r["polygon"]), "class": r["class"]} for r in rooms["rooms"]],
    }


RULES = {
    "seats": (lambda f, w: distance(f["at"], w["at"]), SEAT_M),
    "table tops": (lambda f, w: 1 - iou(f["polygon"], w["polygon"]), 1 - TABLE_IOU),
    "doors": (lambda f, w: distance(f["at"], w["at"]), DOOR_M),
    "rooms": (lambda f, w: 1 - iou(f["polygon"], w["polygon"]), 1 - ROOM_IOU),
}


def about_vertical(degrees):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return [[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]


def details(kind, matches):
    """What the matches are worth, as one text."""
    if not matches:
        return ""
    share = lambda good: f"{sum(map(good, matches)) / len(matches):.3f}"
    if kind == "seats":
        return f"facing within {FACING_DEG} degrees: " + share(lambda m: degrees_between(m[0]["facing"], m[1]["facing"]) <= FACING_DEG)
    if kind == "table tops":
        return f"mean IoU: {sum(1 - m[2] for m in matches) / len(matches):.3f}"
    if kind == "doors":
        return f"width within {WIDTH_M} m: " + share(lambda m: abs(m[0]["width_m"] - m[1]["width_m"]) <= WIDTH_M)
    return "class right: " + share(lambda m: m[0]["class"] == m[1]["class"])


def main():
    arguments = sys.argv[1:]
    yaw = 0.0
    if "--turned" in arguments:
        at = arguments.index("--turned")
        yaw = float(arguments[at + 1])
        del arguments[at:at + 2]
    if not arguments or len(arguments) % 2:
        sys.exit(__doc__)
    identity = about_vertical(0)
    total = {kind: [[], 0, 0] for kind in RULES}
    for truth_folder, plan_folder in zip(arguments[::2], arguments[1::2]):
        truth = read(truth_folder, "_truth", identity)
        plan = read(plan_folder, "", about_vertical(-yaw))
        for kind, (cost, most) in RULES.items():
            total[kind][0] += pairs(plan[kind], truth[kind], cost, most)
            total[kind][1] += len(plan[kind])
            total[kind][2] += len(truth[kind])
    for kind, (matches, found, wanted) in total.items():
        f1 = 2 * len(matches) / (found + wanted) if found + wanted else 1.0
        print(f"{kind:<11} F1 {f1:.3f}  found {found:>4}  true {wanted:>4}  matched {len(matches):>4}  {details(kind, matches)}")


if __name__ == "__main__":
    main()
