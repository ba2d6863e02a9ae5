#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Maps the two development recordings under several choices and prints the tables of docs/benchmarks.md.

Needs the release build, the recordings and the networks (PANOPTIC_SHARED, default ../shared). Standard library only.
"""
import argparse
import json
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
ENET = "enet_scannet_nyu40.toml"
DEEPLAB = "deeplabv3_mnv2_ade20k32.toml"
YOLO = "yolov8n_seg_coco.toml"

# name -> recording, semantic network, instance network, label set, calibrated, more options
CHOICES = {
    "kitchen, ENet + YOLO, indoor": ("kitchen", ENET, YOLO, "indoor", True, []),
    "kitchen, ENet + YOLO, indoor, colour taken as registered": ("kitchen", ENET, YOLO, "indoor", False, []),
    "kitchen, DeepLab + YOLO, indoor": ("kitchen", DEEPLAB, YOLO, "indoor", True, []),
    "kitchen, ENet + YOLO, scannet20": ("kitchen", ENET, YOLO, "scannet20", True, []),
    "kitchen, ENet + YOLO, indoor, raycast": ("kitchen", ENET, YOLO, "indoor", True, ["integrator.method=raycast"]),
    "hololens, ENet + YOLO, indoor": ("hololens", ENET, YOLO, "indoor", False, []),
    "hololens, DeepLab + YOLO, indoor": ("hololens", DEEPLAB, YOLO, "indoor", False, []),
    "hololens, ENet + YOLO, scannet20": ("hololens", ENET, YOLO, "scannet20", False, []),
}


def measure(name, out, shared):
    recording, semantic, instance, labels, calibrated, settings = CHOICES[name]
    folder = out / name.replace(", ", "_").replace(" ", "_").replace("+", "and")
    command = [ROOT / "build/release/panoptic", "run", shared / "data" / recording, "-o", folder, "--labels", labels]
    command += ["--semantic", ROOT / "configs/models" / semantic, "--instance", ROOT / "configs/models" / instance]
    command += ["--calibration", ROOT / "configs/kitchen.toml"] if calibrated else []
    for setting in settings:
        command += ["--set", setting]
    environment = dict(os.environ, PANOPTIC_MODELS=os.environ.get("PANOPTIC_MODELS", str(shared / "models")))
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=environment)
    scores = folder / "scores.json"
    clicks = shared / "data" / recording / "clicks.json"
    subprocess.run([sys.executable, ROOT / "tools/score_clicks.py", folder, clicks, "--json", scores], check=True, stdout=subprocess.DEVNULL)
    return json.loads((folder / "report.json").read_text()), json.loads(scores.read_text())


def percent(value):
    return "-" if value is None else f"{100 * value:.1f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "out/measure", help="folder for the runs")
    parser.add_argument("--only", help="choices whose name contains this text")
    arguments = parser.parse_args()
    shared = pathlib.Path(os.environ.get("PANOPTIC_SHARED", ROOT / "../shared")).resolve()
    if not (shared / "data").is_dir():
        sys.exit(f"measure_recordings: no recordings in {shared}; set PANOPTIC_SHARED to their folder")
    results = {n: measure(n, arguments.out, shared) for n in CHOICES if not arguments.only or arguments.only in n}

    print("| run | J | class acc. | stuff | things | pairs F1 | found | coverage | objects in map |")
    print("|---|---|---|---|---|---|---|---|---|")
    for name, (_, s) in results.items():
        cells = [s["J"], s["class_accuracy"], s["stuff_accuracy"], s["thing_accuracy"], s["pairs"]["f1"], s["objects"]["share"], s["coverage"]]
        print(f"| {name} | {' | '.join(percent(c) for c in cells)} | {s['objects_in_map']} |")
    print("\n| run | register | reference | track | integrate | fusion p50 | fusion p95 | predict p50 | frames/s | peak MB | map MB |")
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    for name, (r, _) in results.items():
        stages = r["stages"]
        p50 = [f"{stages[k]['p50_ms']:.2f}" for k in ("register", "reference", "track", "integrate", "fusion")]
        tail = [f"{stages['fusion']['p95_ms']:.1f}", f"{stages['predict']['p50_ms']:.0f}", f"{r['frames_per_s']:.1f}"]
        print(f"| {name} | {' | '.join(p50 + tail)} | {r['peak_rss_mb']:.0f} | {r['map_memory_mb']:.0f} |")


if __name__ == "__main__":
    main()
