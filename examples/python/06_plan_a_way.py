# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Finds a way over the floor of a map, from its widest place to an object, and draws it. Needs matplotlib.

    06_plan_a_way.py MAP.panoptic OBJECT PICTURE.png

OBJECT is the name of a node of scene.glb: chair_44.
"""
import sys

import numpy as np

import panoptic as pf


def main(path: str, name: str, picture: str) -> None:
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.colors import ListedColormap

    room = pf.load_map(path)
    frame = pf.up_frame(room)
    agent = pf.AgentSize(radius_m=0.2, height_m=1.2)
    grids = pf.floor_grids(room, frame, agent=agent)

    floor = pf.NavigationMesh(room, frame, agent)
    rows, columns = np.nonzero(grids.standing == pf.FREE)
    free = np.column_stack([*(grids.origin_m[:, None] + (np.array([columns, rows]) + 0.5) * grids.cell_m), np.full(len(rows), 0.5)])
    places = np.array([place for place in free if floor.is_walkable(place)])
    clearance_m = pf.DistanceField(room, frame).distances_m(places)
    way = floor.path_to(places[np.nanargmax(clearance_m)], room.node_named(name))
    print(f"{way.length_m:.2f} m to {name}" if way else way.why_not)

    figure, axes = plt.subplots(figsize=(8, 8))
    (x, y), (height, width) = grids.origin_m, grids.standing.shape
    axes.imshow(grids.standing, origin="lower", extent=(x, x + width * grids.cell_m, y, y + height * grids.cell_m),
                cmap=ListedColormap(["0.85", "white", "0.35"]), vmin=pf.UNKNOWN, vmax=pf.OCCUPIED)
    for thing in pf.plan_home(room, frame).furniture:
        if thing["class_name"] in ("unknown", "otherfurniture"):
            continue
        axes.fill(*thing["polygon"].T, alpha=0.3)
        axes.text(*thing["polygon"].mean(axis=0), thing["class_name"], fontsize=7, ha="center", va="center")
    axes.plot(*way.points_m.T[:2], "-o", color="tab:red", markersize=3)
    axes.set(aspect="equal", xlabel="x, m", ylabel="y, m")
    figure.savefig(picture, dpi=100, bbox_inches="tight")


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    try:
        main(*sys.argv[1:])
    except pf.Error as error:
        sys.exit(str(error))
