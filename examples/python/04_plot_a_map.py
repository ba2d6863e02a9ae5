# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Plots a map from above: things in their colours and with their names, walls and other stuff in grey. Needs matplotlib.

    04_plot_a_map.py MAP.panoptic PICTURE.png
"""
import sys

import numpy as np

import panoptic as pf


def main(path: str, picture: str) -> None:
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    room = pf.load_map(path)
    mesh = room.mesh()
    ids, of_vertex = np.unique(mesh.panoptic_id, return_inverse=True)
    class_of = dict(zip(mesh.panoptic_id.tolist(), mesh.class_id.tolist()))
    is_thing = np.array([room.labels.is_thing(class_of[i]) for i in ids.tolist()])[of_vertex]
    colors = np.array([room.labels.color_of(i) for i in ids.tolist()])[of_vertex] / 255

    figure, axes = plt.subplots(figsize=(8, 8))
    walls = mesh.vertices[(mesh.class_id > 0) & ~is_thing & (abs(mesh.normals[:, 2]) < 0.5)]  # what stands, of a map with z up
    axes.plot(walls[:, 0], walls[:, 1], "s", color="0.8", markersize=0.6)
    axes.scatter(mesh.vertices[is_thing, 0], mesh.vertices[is_thing, 1], s=1.5, marker="s", linewidths=0, c=colors[is_thing])
    things = [item for item in room.objects() if room.labels.is_thing(item.class_id)]
    for item in sorted(things, key=lambda item: item.voxels)[-20:]:  # the largest have room for their names
        axes.text(item.center_m[0], item.center_m[1], item.class_name, fontsize=7, ha="center", va="center",
                  bbox=dict(boxstyle="round,pad=0.15", facecolor="white", edgecolor="none", alpha=0.7))
    axes.set(aspect="equal", xlabel="x, m", ylabel="y, m")
    figure.savefig(picture, dpi=100, bbox_inches="tight")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
