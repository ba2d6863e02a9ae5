# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""From a run's report and scores to the tables of tools/score_recordings: flat records, their summaries, Markdown."""

# name in the table -> where tools/score_clicks.py puts it; all of these are shares, shown in percent
SCORES = {"J": ("J",), "stuff": ("stuff_accuracy",), "things": ("thing_accuracy",), "pairs F1": ("pairs", "f1"), "found": ("objects", "share"),
          "class acc.": ("class_accuracy",), "coverage": ("coverage",)}
COUNTS = {"objects": "objects_in_map", "named": "named_objects"}
STAGES = ("register", "reference", "track", "integrate")


def flat_record(report, scores):
    record = {}
    for name, path in SCORES.items():
        value = scores
        for key in path:
            value = value[key]
        record[name] = value
    record.update({name: scores[key] for name, key in COUNTS.items()})
    stages = report["stages"]
    record["fusion p50 ms"] = stages["fusion"]["p50_ms"]
    record["fusion p95 ms"] = stages["fusion"]["p95_ms"]
    record.update({f"{name} p50 ms": stages[name]["p50_ms"] for name in STAGES if name in stages})
    record["predict p50 ms"] = stages["predict"]["p50_ms"]
    record["frames/s"] = report["frames_per_s"]
    record["peak MB"] = report["peak_rss_mb"]
    record["map MB"] = report["map_memory_mb"]
    return record


def average(records):
    """Number by number; nothing where one of them has nothing."""
    names = [n for n in records[0] if all(n in r for r in records)]
    return {n: None if any(r[n] is None for r in records) else sum(r[n] for r in records) / len(records) for n in names}


def summary(records):
    """{name: {mean, min, max}} over the moves."""
    middle = average(records)
    return {n: None if m is None else {"mean": m, "min": min(r[n] for r in records), "max": max(r[n] for r in records)}
            for n, m in middle.items()}


def cell(name, value, spread):
    if value is None:
        return "–"
    digits, scale = (1, 100) if name in SCORES else (0, 1) if name in ("peak MB", "map MB", "predict p50 ms") else (1, 1)
    text = f"{scale * value['mean']:.{digits}f}"
    if spread and value["max"] > value["min"]:
        text += f" ({scale * value['min']:.{digits}f}..{scale * value['max']:.{digits}f})"
    return text


def table(summaries, names, spread=True):
    """Markdown; summaries: {variant: {name: {mean, min, max}}}."""
    lines = [f"| choice | {' | '.join(names)} |", "|---" * (len(names) + 1) + "|"]
    for variant, values in summaries.items():
        lines.append(f"| {variant} | {' | '.join(cell(n, values.get(n), spread) for n in names)} |")
    return "\n".join(lines)


def differences(summaries):
    """Each variant's means less the first's."""
    first, *others = summaries.items()
    names = [*SCORES, *COUNTS, "fusion p50 ms", "peak MB"]

    def difference(values, name):
        mine, base = values[name], first[1][name]
        return "–" if mine is None or base is None else f"{(100 if name in SCORES else 1) * (mine['mean'] - base['mean']):+.1f}"

    lines = [f"| less {first[0]} | {' | '.join(names)} |", "|---" * (len(names) + 1) + "|"]
    return "\n".join(lines + [f"| {variant} | {' | '.join(difference(values, n) for n in names)} |" for variant, values in others])


def markdown(results, ablation, live):
    """results: {recording or 'average': {variant: summary}}."""
    parts = []
    times = ["fusion p50 ms", "fusion p95 ms", *(f"{s} p50 ms" for s in STAGES), "peak MB", "map MB"]
    times += ["predict p50 ms", "frames/s"] if live else []
    for place, summaries in results.items():
        parts.append(f"### {place}\n\n" + table(summaries, [*SCORES, *COUNTS, "fusion p50 ms", "peak MB"]))
        if ablation and len(summaries) > 1:
            parts.append(differences(summaries))
        if place != "average":
            parts.append(table(summaries, times, spread=False))
    return "\n\n".join(parts) + "\n"


def summarise(records, names, recordings, moves):
    """records: {(variant, recording, move): flat record}. The average is taken move by move, then summarised."""
    results = {}
    for recording in recordings:
        results[recording] = {v: summary([records[v, recording, m] for m in moves]) for v in names}
    if len(recordings) > 1:
        results["average"] = {v: summary([average([records[v, r, m] for r in recordings]) for m in moves]) for v in names}
    return results
