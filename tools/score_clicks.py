#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Scores a labelled map against points that a person labelled by hand (sparse ground truth).

A point is covered if a mesh vertex lies within --max-distance of it; the nearest such vertex says what the map thinks it is
(of equally near ones the first in the file).

Class accuracy. Over covered points whose class, or one of the classes accepted in `also`, is in the map's label set. A point
counts under its class, or under the first of `also` in the label set if its class is not there. It is right if the map says its
class or any of `also`. The accuracy of each class is averaged, each class weighing the same: over all classes, over stuff and
over things. Stuff and things are what the label set says, not the clicks.

Same-object pairs. Over all pairs of covered points with `instance_ok` and an object's name: precision is the share of pairs with
the same panoptic id that have the same object's name, recall the share of pairs with the same name that have the same id.
Unknown (id 0) is no id and equals nothing; the id of a stuff class counts as an id.

Objects found. Of the named objects with at least 3 covered `instance_ok` points, the share whose most frequent id (of equally
frequent ones the lowest) is a thing's and not the most frequent id of another such object.

J is the mean of stuff accuracy, thing accuracy, pair F1 and objects found; n/a if one of them is.

Exit code: 0 scored, 1 a file is missing or wrong (one line on stderr), 2 wrong usage.
"""
import argparse
import json
import math
import struct
import sys
from collections import Counter, defaultdict
from pathlib import Path

MIN_POINTS_OF_OBJECT = 3
UNKNOWN = 0
PLY_TYPES = {"char": "b", "int8": "b", "uchar": "B", "uint8": "B", "short": "h", "int16": "h", "ushort": "H", "uint16": "H",
             "int": "i", "int32": "i", "uint": "I", "uint32": "I", "float": "f", "float32": "f", "double": "d", "float64": "d"}
NEEDED_PROPERTIES = ("x", "y", "z", "class_id", "panoptic_id")


class BadInput(Exception):
    """One line for a person: what is wrong, where, what to do."""


class Labels:
    """The map's label set: ids to names, and which are things."""

    def __init__(self, entries, source):
        try:
            self.name_of = {int(e["id"]): str(e["name"]) for e in entries}
            self.is_thing = {str(e["name"]): bool(e["is_thing"]) for e in entries}
        except (KeyError, TypeError, ValueError) as error:
            raise BadInput(f"{source}: `labels` must be a list of {{id, name, is_thing}}: {error!r}") from None
        self.first_thing = max(self.name_of, default=0) + 1

    def __contains__(self, name):
        return name in self.is_thing

    def name(self, class_id):
        return self.name_of.get(class_id, "unknown")


def read_bytes(path):
    try:
        return path.read_bytes()
    except OSError as error:
        raise BadInput(f"cannot read {path}: {error.strerror}; check the path") from None


def read_json(path):
    try:
        return json.loads(read_bytes(path))
    except ValueError as error:
        raise BadInput(f"{path} is not JSON: {error}; the file may be cut off") from None


def read_labels(path):
    report = read_json(path)
    if not isinstance(report, dict) or "labels" not in report:
        raise BadInput(f"{path} has no `labels`: it is not the report.json of a run")
    return Labels(report["labels"], path)


def read_clicks(path):
    clicks = read_json(path)
    try:
        for p in clicks["points"]:
            if len(p["xyz"]) != 3 or not all(math.isfinite(c) for c in p["xyz"]):
                raise ValueError(f"bad xyz {p['xyz']}")
            if not (isinstance(p["class"], str) and isinstance(p["also"], list)):
                raise ValueError("class must be a name and also a list of names")
            p["object"], p["instance_ok"]  # pylint: disable=pointless-statement
        return clicks["points"]
    except (KeyError, TypeError, ValueError) as error:
        raise BadInput(f"{path}: `points` must be a list of {{xyz, class, also, object, instance_ok}}: {error!r}") from None


def parse_header(data, path):
    """The vertex count, the record's struct format, the property names, and where the records begin."""
    end = data.find(b"end_header\n", 0, 1 << 16)
    if not data.startswith(b"ply\n") or end < 0:
        raise BadInput(f"{path} is not a PLY file with a complete header")
    lines = [line.split() for line in data[:end].decode("latin-1").splitlines()]
    if ["format", "binary_little_endian", "1.0"] not in lines:
        raise BadInput(f"{path}: only binary little-endian PLY can be read")
    element, count, codes, names = None, 0, "", []
    elements = []
    for words in lines:
        if words[:1] == ["element"] and len(words) == 3 and words[2].isdigit():
            element = words[1]
            elements.append(element)
            count = int(words[2]) if element == "vertex" else count
        elif words[:1] == ["property"] and element == "vertex":
            if len(words) != 3 or words[1] not in PLY_TYPES:
                raise BadInput(f"{path}: cannot read the vertex property '{' '.join(words)}'")
            codes += PLY_TYPES[words[1]]
            names.append(words[2])
    missing = [name for name in NEEDED_PROPERTIES if name not in names]
    if elements[:1] != ["vertex"] or missing:
        raise BadInput(f"{path}: vertices must come first and have {', '.join(NEEDED_PROPERTIES)}; missing: {', '.join(missing) or 'none'}")
    return count, struct.Struct("<" + codes), names, end + len(b"end_header\n")


def read_vertices(path):
    """Tuples (x, y, z, class_id, panoptic_id), one per vertex, in the file's order."""
    data = read_bytes(path)
    count, record, names, begin = parse_header(data, path)
    if len(data) - begin < count * record.size:
        raise BadInput(f"{path} is cut off: {count} vertices take {count * record.size} bytes, {len(data) - begin} are there")
    x, y, z, class_id, panoptic_id = (names.index(name) for name in NEEDED_PROPERTIES)
    for v in record.iter_unpack(memoryview(data)[begin:begin + count * record.size]):
        yield v[x], v[y], v[z], v[class_id], v[panoptic_id]


def look_up(points, vertices, max_distance):
    """Per point (class_id, panoptic_id) of the nearest vertex or None; and how many vertices each panoptic id has."""
    scale = 1 / max_distance
    floor = math.floor
    near = defaultdict(list)  # cell -> the points that a vertex there may be near to
    for index, point in enumerate(points):
        cx, cy, cz = (floor(c * scale) for c in point)
        for dx in (-1, 0, 1):
            for dy in (-1, 0, 1):
                for dz in (-1, 0, 1):
                    near[cx + dx, cy + dy, cz + dz].append(index)
    best = [(max_distance, None)] * len(points)
    sizes = Counter()
    near = dict(near)
    try:
        for x, y, z, class_id, panoptic_id in vertices:
            sizes[panoptic_id] += 1
            for index in near.get((floor(x * scale), floor(y * scale), floor(z * scale)), ()):
                distance = math.dist(points[index], (x, y, z))
                if distance < best[index][0] or (best[index][1] is None and distance <= max_distance):
                    best[index] = (distance, (class_id, panoptic_id))
    except (ValueError, OverflowError):
        raise BadInput("the mesh has a vertex that is not finite") from None
    return [found for _, found in best], sizes


def score_classes(covered, labels):
    """covered: pairs of point and (class_id, panoptic_id). One row per class that has points, by name."""
    rows = {}
    for point, (class_id, _) in covered:
        accepted = [point["class"], *point["also"]]
        scored_as = next((name for name in accepted if name in labels), None)
        if scored_as is None:
            continue
        kind = "thing" if labels.is_thing[scored_as] else "stuff"
        row = rows.setdefault(scored_as, {"kind": kind, "points": 0, "right": 0, "mistaken_for": Counter()})
        row["points"] += 1
        said = labels.name(class_id)
        if said in accepted and class_id in labels.name_of:
            row["right"] += 1
        else:
            row["mistaken_for"][said] += 1
    for row in rows.values():
        row["accuracy"] = row["right"] / row["points"]
        row["mistaken_for"] = dict(row["mistaken_for"].most_common())
    return dict(sorted(rows.items(), key=lambda item: (item[1]["kind"], item[0])))


def mean(values):
    values = list(values)
    return sum(values) / len(values) if values else None


def ratio(part, whole):
    return part / whole if whole else None


def pairs_in(counts):
    return sum(n * (n - 1) // 2 for n in counts)


def score_pairs(instances):
    """instances: pairs of object name and panoptic id."""
    same_id = pairs_in(Counter(i for _, i in instances if i != UNKNOWN).values())
    same_name = pairs_in(Counter(name for name, _ in instances).values())
    both = pairs_in(Counter((name, i) for name, i in instances if i != UNKNOWN).values())
    return {"precision": ratio(both, same_id), "recall": ratio(both, same_name), "f1": ratio(2 * both, same_id + same_name)}


def score_objects(instances, first_thing):
    ids_of = defaultdict(list)
    for name, panoptic_id in instances:
        ids_of[name].append(panoptic_id)
    majority = {}
    for name, ids in ids_of.items():
        if len(ids) >= MIN_POINTS_OF_OBJECT:
            majority[name] = min(Counter(ids).items(), key=lambda item: (-item[1], item[0]))[0]
    owners = Counter(majority.values())
    found = sorted(name for name, i in majority.items() if i >= first_thing and owners[i] == 1)
    return {"share": ratio(len(found), len(majority)), "found": found, "missed": sorted(set(majority) - set(found))}


def score(points, labels, vertices, max_distance):
    found, sizes = look_up([tuple(p["xyz"]) for p in points], vertices, max_distance)
    covered = [(p, f) for p, f in zip(points, found) if f is not None]
    classes = score_classes(covered, labels)
    instances = [(p["object"], f[1]) for p, f in covered if p["instance_ok"] and p["object"] is not None]
    result = {
        "points": len(points),
        "covered": len(covered),
        "coverage": ratio(len(covered), len(points)),
        "max_distance_m": max_distance,
        "class_scored_points": sum(row["points"] for row in classes.values()),
        "classes": classes,
        "class_accuracy": mean(row["accuracy"] for row in classes.values()),
        "stuff_accuracy": mean(row["accuracy"] for row in classes.values() if row["kind"] == "stuff"),
        "thing_accuracy": mean(row["accuracy"] for row in classes.values() if row["kind"] == "thing"),
        "pairs": score_pairs(instances),
        "objects": score_objects(instances, labels.first_thing),
        "objects_in_map": sum(1 for i in sizes if i >= labels.first_thing),
        "named_objects": len({p["object"] for p in points if p["object"] is not None}),
    }
    parts = [result["stuff_accuracy"], result["thing_accuracy"], result["pairs"]["f1"], result["objects"]["share"]]
    result["J"] = None if None in parts else mean(parts)
    return result


def percent(value):
    return "   n/a" if value is None else f"{100 * value:5.1f}%"


def print_table(result):
    print(f"{'class':<16}{'kind':<7}{'points':>7}{'right':>7}{'accuracy':>10}   most often mistaken for")
    for name, row in result["classes"].items():
        wrong = ", ".join(f"{other} {n}" for other, n in list(row["mistaken_for"].items())[:2])
        print(f"{name:<16}{row['kind']:<7}{row['points']:>7}{row['right']:>7}{percent(row['accuracy']):>10}   {wrong}")
    pairs, objects = result["pairs"], result["objects"]
    counted = len(objects["found"]) + len(objects["missed"])
    print(f"\ncoverage          {percent(result['coverage'])}   {result['covered']} of {result['points']} points have a vertex within "
          f"{100 * result['max_distance_m']:g} cm; {result['class_scored_points']} have a class of the label set")
    print(f"class accuracy    {percent(result['class_accuracy'])}   mean over classes")
    print(f"  stuff           {percent(result['stuff_accuracy'])}")
    print(f"  things          {percent(result['thing_accuracy'])}")
    print(f"same-object pairs {percent(pairs['f1'])}   F1 of precision {percent(pairs['precision']).strip()}, "
          f"recall {percent(pairs['recall']).strip()}")
    print(f"objects found     {percent(objects['share'])}   {len(objects['found'])} of {counted} with {MIN_POINTS_OF_OBJECT} points or more")
    if objects["missed"]:
        print(f"  missed: {', '.join(objects['missed'])}")
    print(f"objects in the map {result['objects_in_map']}, named in the clicks {result['named_objects']}")
    print(f"J                 {percent(result['J'])}   mean of stuff, things, pairs F1, objects found")


def positive(text):
    value = float(text)
    if not (math.isfinite(value) and value > 0):
        raise argparse.ArgumentTypeError("must be a positive number of metres")
    return value


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out_dir", type=Path, metavar="OUT_DIR", help="the folder that `panoptic run` wrote: mesh.ply, report.json")
    parser.add_argument("clicks", type=Path, metavar="CLICKS.json", help="the labelled points, in the map's world coordinates")
    parser.add_argument("--json", type=Path, metavar="F", help="write the scores there, too")
    parser.add_argument("--max-distance", type=positive, default=0.05, metavar="M", help="in metres (default 0.05)")
    options = parser.parse_args(arguments)
    try:
        labels = read_labels(options.out_dir / "report.json")
        points = read_clicks(options.clicks)
        result = score(points, labels, read_vertices(options.out_dir / "mesh.ply"), options.max_distance)
        if options.json is not None:
            options.json.write_text(json.dumps(result, indent=2) + "\n")
    except BadInput as error:
        print(f"score_clicks: {error}", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"score_clicks: cannot write {options.json}: {error.strerror}", file=sys.stderr)
        return 1
    print_table(result)
    return 0


if __name__ == "__main__":
    sys.exit(main())
