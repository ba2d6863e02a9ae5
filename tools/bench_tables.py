# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""From the JSON of the benchmarks to the tables (Markdown) and charts of docs/benchmarks.md."""
import svg_chart

BAND_BYTES = 20  # of a voxel: distance, weight, label weight, label, three colours
# What one pixel or voxel costs in arithmetic, counted from the kernels' source: operations on floats, a division, a root or a
# conversion as one. Projection looks at every voxel of a touched block, the update at those of the band.
OPERATIONS = {"register": 40, "reference": 12, "touch": 20, "project": 26, "update": 60}


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def stage_ms(result, *stages, quantile="p50_ms"):
    """The sum of the stages' medians."""
    return sum(result["stages"][s][quantile] for s in stages)


STAGE_ROWS = (("register", ("register",)), ("reference + track", ("reference", "track")), ("integrate", ("integrate",)), ("fusion", ("fusion",)),
              ("incremental mesh of 10 frames", ("mesh_incremental",)), ("full mesh", ("mesh_full",)))
STAGE_TARGETS = {0.024: {"register": 0.7, "reference + track": 1.0, "integrate": 2.0, "fusion": 4, "incremental mesh of 10 frames": 6, "full mesh": 15},
                 0.01: {"integrate": 5.5, "fusion": 8, "incremental mesh of 10 frames": 30, "full mesh": 120}}


def stages_table(one, all_threads):
    """The stages of a recording on one thread and on all; a p95 of sums is the sum of the p95, so at most too high."""
    voxel_m = min(STAGE_TARGETS, key=lambda v: abs(v - one["voxel_size_m"]))
    rows = []
    for name, stages in STAGE_ROWS:
        target = STAGE_TARGETS[voxel_m].get(name)
        cells = [f"{stage_ms(r, *stages, quantile=q):.2f}" for r in (one, all_threads) for q in ("p50_ms", "p95_ms")]
        rows.append([name, *cells, "–" if target is None else f"{target:g}"])
    threads = all_threads["threads"]
    return table(["stage", "1 thread p50", "p95", f"{threads} threads p50", "p95", "target"], rows)


def memory_line(result):
    return (f"Map: {result['map_bytes_per_observed_voxel']:.1f} bytes per observed voxel (target 35), {result['map_mb']:.0f} MB in {result['blocks']} blocks; "
            f"peak {result['peak_rss_mb']:.0f} MB besides the decoded frames (target 150 at 2.4 cm).")


def scaling_table(name, rows):
    header = {"image": ("million pixels", lambda r: f"{r['megapixels']:.2f}"), "voxel": ("voxel, cm", lambda r: f"{r['voxel_cm']:.3g}"),
              "map": ("blocks in the map", lambda r: f"{r['blocks']}"), "objects": ("segments a frame", lambda r: f"{r['segments']:.1f}"),
              "threads": ("threads", lambda r: f"{r['threads']}")}
    title, cell = header[name]
    stages = [s for s in ("register", "reference", "track", "integrate", "fusion") if s in rows[0]]
    return table([title, *stages], [[cell(r), *[f"{r[s]:.2f}" for s in stages]] for r in rows])


def growth_line(rows):
    """How much dearer a frame is in the largest map than in the smallest."""
    first, last = rows[0], rows[-1]
    return (f"From {first['blocks']} to {last['blocks']} blocks ({last['blocks'] / first['blocks']:.1f} times the map) a frame's time changes by "
            f"{(last['fusion'] / first['fusion'] - 1) * 100:+.0f} %.")


def peers_table(result):
    rows = [[f"{r['voxel_m'] * 100:g} cm", f"{r['ours_ms']:.2f}", f"{r['grid_ms']:.2f}", f"{r['volume_ms']:.2f}", f"{r['ratio']:.1f}",
             *(f"{r[who + '_mb']:.0f}" for who in ("ours", "grid", "volume"))] for r in result["rows"]]
    return table(["voxel", "ours, with labels (ms)", "VoxelBlockGrid (ms)", "ScalableTSDFVolume (ms)", "ratio to the faster",
                  "map MB: ours, with labels", "VoxelBlockGrid", "ScalableTSDFVolume"], rows)


def surfaces_table(result):
    rows = []
    for r in result["rows"]:
        for name, scores in r.get("surface", {}).items():
            five, half = scores["at"]
            rows.append([f"{r['voxel_m'] * 100:g} cm", name, f"{five['f_score'] * 100:.2f}", f"{half['f_score'] * 100:.2f}",
                         f"{scores['accuracy_m'] * 1e3:.2f}", f"{scores['completion_m'] * 1e3:.2f}"])
    return table(["voxel", "mesh", "F 5 cm", "F 2.5 cm", "accuracy, mm", "completion, mm"], rows)


STAGES = ("register", "reference", "track", "integrate", "maintain", "regularize")


def buildings_table(rows):
    """rows: (rooms, result of panoptic-bench --endurance)."""
    cells = []
    for rooms, result in rows:
        looks = result["looks"]
        last = looks[-1]
        elapsed = {s: weighted(looks, lambda look, s=s: look["stages_ms"].get(s, 0)) for s in STAGES}
        total = sum(elapsed.values())
        cells.append([str(rooms), str(last["frames"]), f"{last['observed_voxels'] / 1e6:.2f}", f"{last['map_mb']:.0f}",
                      f"{last['map_mb'] * 1e6 / last['observed_voxels']:.1f}", f"{result['peak_rss_mb']:.0f}",
                      f"{weighted(looks, lambda look: look['cpu_ms']):.2f}", *(f"{elapsed[s] / total * 100:.0f} %" for s in STAGES)])
    return table(["rooms", "frames", "million observed voxels", "map MB", "bytes per observed voxel", "peak MB", "CPU ms a frame", *STAGES], cells)


def weighted(looks, value):
    """The mean over frames of what looks hold as means since the look before."""
    before = [0] + [look["frames"] for look in looks[:-1]]
    spans = [look["frames"] - b for look, b in zip(looks, before)]
    return sum(span * value(look) for span, look in zip(spans, looks)) / sum(spans)


def homes_line(result, homes):
    """How much dearer a frame is in each home than in the first. REQUIRES that looks do not lie across homes."""
    looks = result["looks"]
    each = len(looks) // homes
    means = [sum(look["cpu_ms"] for look in looks[i * each:(i + 1) * each]) / each for i in range(homes)]
    changes = ", ".join(f"{(m / means[0] - 1) * 100:+.0f} %" for m in means[1:])
    return (f"A frame of the first flat takes {means[0]:.2f} ms of the processor, of the next ones {changes}, in one run. "
            f"The map of all has {looks[-1]['map_mb']:.0f} MB.")


def looks_chart(title, unit, result, **others):
    """The process without decoded frames, other values of looks by their names, and the time of a frame, over the frames."""
    values = {"process, 10 MB": lambda look: (look["rss_mb"] - result["decoded_mb"]) / 10, **others, "frame, ms": lambda look: look["cpu_ms"]}
    series = {name: [(look["frames"] / 1e3, value(look)) for look in result["looks"]] for name, value in values.items()}
    return svg_chart.line_chart(title, "thousand frames", unit, series)


def map_chart(title, result):
    return looks_chart(title, "10 MB, ms of CPU", result, **{"map, 10 MB": lambda look: look["map_mb"] / 10})


def endurance_table(result, rows=8):
    looks = result["looks"]
    chosen = sorted({round(i * (len(looks) - 1) / (rows - 1)) for i in range(rows)})
    cells = [[f"{look['frames']:,}", f"{look['cpu_ms']:.2f}", f"{look['rss_mb'] - result['decoded_mb']:.0f}", f"{look['map_mb']:.1f}",
              f"{look['file_mb']:.2f}", str(look["objects"]), f"{look['ids_given']:,}"] for look in (looks[i] for i in chosen)]
    return table(["frames", "CPU ms a frame", "process MB (without the decoded frames)", "map MB", "file MB", "objects", "ids given"], cells)


def endurance_line(result):
    """From the end of the first tenth to the end."""
    looks = result["looks"]
    early, late = looks[max(0, len(looks) // 10 - 1)], looks[-1]
    middle = len(looks) // 2
    times = [sum(look["cpu_ms"] for look in half) / len(half) for half in (looks[:middle], looks[middle:])]
    return (f"From frame {early['frames']:,} to frame {late['frames']:,}: process {late['rss_mb'] - early['rss_mb']:+.1f} MB, map "
            f"{late['map_mb'] - early['map_mb']:+.1f} MB, file {late['file_mb'] - early['file_mb']:+.2f} MB; time of a frame in the second half "
            f"{(times[1] / times[0] - 1) * 100:+.0f} % of the first half's.")


def endurance_chart(result):
    return looks_chart("One room again and again", "10 MB, MB, ms of CPU", result, **{"file, MB": lambda look: look["file_mb"]})


def machine_table(machine):
    rows = [[str(m["threads"]), f"{m['copy_gb_per_s']:.1f}", f"{m['triad_gb_per_s']:.1f}", f"{m['float_gop_per_s']:.0f}"] for m in machine]
    return table(["threads", "copy, GB/s", "triad, GB/s", "multiply and add in registers, 10^9 float operations/s"], rows)


def frame_traffic(work):
    """Bytes that a frame has to move at least, stage by stage, and its float operations. work: pixels, color_pixels, touched_voxels,
    band_voxels of a frame."""
    pixels, color = work["pixels"], work["color_pixels"]
    registered = pixels * (4 + 4 + 2)
    return {"register": (pixels * 4 + color * 5 + registered, pixels * OPERATIONS["register"]),
            "reference": (pixels * (4 + 2), pixels * OPERATIONS["reference"]),
            "track": (pixels * (2 + 2) * 2 + pixels * 2, 0),
            "integrate": (pixels * (4 + 4 + 2) + 2 * work["band_voxels"] * BAND_BYTES,
                          pixels / 4 * OPERATIONS["touch"] + work["touched_voxels"] * OPERATIONS["project"]
                          + work["band_voxels"] * OPERATIONS["update"])}


def roofline_table(work, result, machine):
    """How far each stage is from the time that its bytes and its operations would take at the machine's limits."""
    limits = next(m for m in machine if m["threads"] == result["threads"])
    rows = []
    total = [0.0, 0.0]
    for stage, (moved, operations) in frame_traffic(work).items():
        total = [total[0] + moved, total[1] + operations]
        rows.append(roofline_row(stage, moved, operations, result["stages"][stage]["p50_ms"], limits))
    rows.append(roofline_row("fusion", *total, result["stages"]["fusion"]["p50_ms"], limits))
    return table(["stage", "MB", "10^6 operations", "ms at the bandwidth", "ms at the peak", "measured ms", "share of the nearer limit"], rows)


def roofline_row(stage, moved, operations, measured_ms, limits):
    by_bytes = moved / limits["copy_gb_per_s"] * 1e-6
    by_operations = operations / limits["float_gop_per_s"] * 1e-6
    return [stage, f"{moved * 1e-6:.1f}", f"{operations * 1e-6:.0f}", f"{by_bytes:.2f}", f"{by_operations:.2f}", f"{measured_ms:.2f}",
            f"{max(by_bytes, by_operations) / measured_ms * 100:.0f} %"]


def kernels_table(result):
    """Google Benchmark's JSON: processor time of each, in a unit that fits."""
    units = {"ns": 1e-3, "us": 1, "ms": 1e3, "s": 1e6}
    counted = ("per_voxel", "triangles", "blocks", "voxels", "MB", "agreement", "peak_MB")
    rows = []
    for b in result["benchmarks"]:
        if b.get("run_type", "iteration") != "iteration":
            continue
        counters = ", ".join(f"{name} {b[name]:.3g}" for name in counted if name in b)
        rows.append([b["name"], f"{b['cpu_time'] * units[b['time_unit']]:.4g}", counters or "–"])
    return table(["kernel", "µs of processor time", "counters"], rows)


def with_section(document, name, body):
    """The document with what stands between `<!-- make_benchmarks: NAME -->` and the next `<!-- end -->` replaced. Raises ValueError
    if there is no such section."""
    begin = f"<!-- make_benchmarks: {name} -->\n"
    end = "<!-- end -->"
    head, found, rest = document.partition(begin)
    if not found or end not in rest:
        raise ValueError(f"there is no section '{name}'")
    return head + begin + body.strip() + "\n" + rest[rest.index(end):]
