#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Scores what maps say of worlds that move, over simulated homes: what is gone, new or moved, which pixels move, and how much of a map is a ghost.

Usage: score_changes.py PANOPTIC WORK --seeds 20 21 22 [--dynamics static people changes busy] [--rooms 1] [--frames 600] [--noise kinect]
                        [--predictions maskrcnn] [--variants with off] [--set KEY=VALUE ...] [--khronos PROGRAM]

PANOPTIC is the program. Every home is made in WORK, mapped and scored (docs/evaluation.md) under each variant, and removed again: one takes 300 MB.
Its scores are kept in WORK and not made again. Variants:
  with        the program as it is
  no_classes  moving.classes=false: only motion tells what moves
  off         nothing is known of motion or change
  khronos     what the published rule of Khronos says is gone or new (--khronos build/release/khronos_changes), on maps of `off` without carving

Claims, truths and pixels are summed over the homes; shares are means. Ghosts and completeness are also given less those of the static home of
the same seed and variant, where --dynamics has `static`. In a static home every claim is wrong."""
import argparse
import json
import pathlib
import shutil
import subprocess

OFF = ["moving.classes=false", "moving.points=false", "moving.objects=false"]
VARIANTS = {"with": [], "no_classes": OFF[:1], "off": OFF, "khronos": [*OFF, "carving.enabled=false"]}
KINDS = ("gone", "new", "moved")
PIXELS = ("true_positives", "false_positives", "false_negatives")
COLUMNS = ("variant", "gone F1", "new F1", "moved F1", "gone", "new", "moved", "pixel precision", "pixel recall", "ghosts %", "less static",
           "completeness %", "less static")


def program(text):
    found = shutil.which(text)
    if found is None:
        raise argparse.ArgumentTypeError(f"no program {text}; build it first")
    return pathlib.Path(found).resolve()


def call(*arguments):
    result = subprocess.run([str(a) for a in arguments], capture_output=True, text=True)
    if result.returncode != 0:
        raise SystemExit(f"{' '.join(str(a) for a in arguments)}\n{result.stderr}")


def claims_of(run):
    """In a static home: nothing is true."""
    objects = json.loads((run / "objects.json").read_text(encoding="utf-8"))["objects"]
    counts = {"gone": sum(o["state"] != "present" for o in objects), "new": sum(o.get("appeared", False) for o in objects),
              "moved": sum(o.get("moved_from") is not None for o in objects)}
    return {kind: {"found": 0, "truths": 0, "claims": counts[kind]} for kind in KINDS}


def score(arguments, home, variant, folder):
    """Maps the home, and keeps what the table needs of its scores."""
    run, masks, scores = folder / "run", folder / "masks", folder / "scores.json"
    settings = [word for s in VARIANTS[variant] + arguments.set for word in ("--set", s)]
    writes = ["--write-moving", masks] if variant in ("with", "no_classes") else []
    call(arguments.panoptic, "run", home, "--predictions", home / "predictions", "--no-pictures", *writes, *settings, "-o", run)
    if variant == "khronos":
        call(arguments.khronos, home, run)
    moves = (home / "dynamics.json").exists()
    asked = ["--changes", *(["--moving", masks] if writes else [])] if moves else []
    call(arguments.panoptic, "eval", run, "--gt", home, *asked, "--json", scores)
    result = json.loads(scores.read_text(encoding="utf-8"))
    surface = result["surface"]["at"][0]
    kept = result["changes"] if moves else {**claims_of(run), "ghost_share": 1 - surface["precision"], "completeness": surface["recall"]}
    for left in (run, masks):
        shutil.rmtree(left, ignore_errors=True)
    return kept


def scores_of_home(arguments, dynamics, seed):
    """By variant; the home is made only if one of them is absent."""
    about = f"{dynamics}_{seed}_{arguments.rooms}_{arguments.frames}_{arguments.noise}_{arguments.predictions}"
    kept = {v: arguments.work / f"{about}_{'_'.join([v, *arguments.set])}.json" for v in arguments.variants}
    folder = arguments.work / about
    home = folder / "home"
    if not all(path.exists() for path in kept.values()):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        call(arguments.panoptic, "simulate", "--seed", seed, "--rooms", arguments.rooms, "--frames", arguments.frames, "--noise",
             arguments.noise, "--predictions", arguments.predictions, "--dynamics", dynamics, "-o", home)
    for variant, path in kept.items():
        if not path.exists():
            path.write_text(json.dumps(score(arguments, home, variant, folder)), encoding="utf-8")
    shutil.rmtree(folder, ignore_errors=True)
    return {variant: json.loads(path.read_text(encoding="utf-8")) for variant, path in kept.items()}


def percent(part, whole):
    return f"{100 * part / whole:.1f}" if whole else "-"


def mean(values):
    return f"{100 * sum(values) / len(values):.2f}" if values else "-"


def difference(homes, static, key):
    """The mean over the seeds that have both."""
    return mean([homes[seed][key] - static[seed][key] for seed in homes if seed in static])


def row(variant, homes, static):
    """`homes`, `static`: scores by seed."""
    sums = {kind: [sum(h[kind][key] for h in homes.values()) for key in ("found", "truths", "claims")] for kind in KINDS}
    pixels = [sum(h.get("moving_pixels", {}).get(key, 0) for h in homes.values()) for key in PIXELS]
    cells = [variant, *(percent(2 * found, truths + claims) for found, truths, claims in sums.values())]
    cells += [f"{found} of {truths}, {claims - found} wrong" for found, truths, claims in sums.values()]
    cells += [percent(pixels[0], pixels[0] + pixels[1]), percent(pixels[0], pixels[0] + pixels[2])]
    surface = {} if variant == "khronos" else homes  # its maps keep all that ever was
    for key in ("ghost_share", "completeness"):
        cells += [mean([h[key] for h in surface.values()]), difference(surface, static, key)]
    return f"| {' | '.join(cells)} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("panoptic", type=program)
    parser.add_argument("work", type=pathlib.Path)
    parser.add_argument("--seeds", type=int, nargs="+", required=True)
    parser.add_argument("--dynamics", nargs="+", choices=("static", "people", "changes", "busy"), default=["static", "people", "changes", "busy"])
    parser.add_argument("--rooms", type=int, default=1)
    parser.add_argument("--frames", type=int, default=600)
    parser.add_argument("--noise", default="kinect")
    parser.add_argument("--predictions", default="maskrcnn")
    parser.add_argument("--variants", nargs="+", choices=VARIANTS, default=["with", "off"])
    parser.add_argument("--set", nargs="+", default=[])
    parser.add_argument("--khronos", type=program)
    arguments = parser.parse_args()
    if "khronos" in arguments.variants and arguments.khronos is None:
        parser.error("--variants khronos needs --khronos PROGRAM")
    scores = {d: {seed: scores_of_home(arguments, d, seed) for seed in arguments.seeds} for d in sorted(set(arguments.dynamics), reverse=True)}
    by_variant = {d: {v: {seed: s[v] for seed, s in homes.items()} for v in arguments.variants} for d, homes in scores.items()}
    for dynamics in arguments.dynamics:
        print(f"\n### {dynamics}, {len(arguments.seeds)} homes\n\n| {' | '.join(COLUMNS)} |\n{'|---' * len(COLUMNS)}|")
        for variant in arguments.variants:
            print(row(variant, by_variant[dynamics][variant], by_variant.get("static", {}).get(variant, {})))


if __name__ == "__main__":
    main()
