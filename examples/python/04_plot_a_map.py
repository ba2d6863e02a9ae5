# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Plots a map from above, coloured by object, with the names of the objects. Needs matplotlib.

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
    ids, inverse = np.unique(mesh.panoptic_id, return_inverse=True)
    colors = np.array([room.labels.color_of(int(i)) for i in ids])[inverse] / 255
    figure, axes = plt.subplots(figsize=(8, 8))
    axes.scatter(mesh.vertices[:, 0], mesh.vertices[:, 1], s=0.5, c=colors)
    for item in room.objects():
        if room.labels.is_thing(item.class_id):
            axes.annotate(f"{item.class_name} {item.id}", item.center_m[:2], fontsize=7, ha="center")
    axes.set(aspect="equal", xlabel="x, m", ylabel="y, m", title=path)
    figure.savefig(picture, dpi=150)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
