# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""What an object looked like in the frames that say most about it."""
import json
import os
import pathlib
from typing import Any, Dict, List, Tuple, Union

import numpy as np
from numpy.typing import NDArray

from . import _core


def crop(frame: _core.Frame, box: Tuple[int, int, int, int], margin: float = 0.25) -> NDArray[np.uint8]:
    """The part of frame.color around a box (u0, v0, u1, v1) in pixels, wider by `margin` of its size: (h, w, 3) uint8, a view."""
    u0, v0, u1, v1 = box
    if u0 >= u1 or v0 >= v1:
        raise _core.Error(f"the box {tuple(box)} is empty")
    grow_u, grow_v = int(margin * (u1 - u0)), int(margin * (v1 - v0))
    part = frame.color[max(0, v0 - grow_v):v1 + grow_v, max(0, u0 - grow_u):u1 + grow_u]
    if part.size == 0:
        raise _core.Error(f"the box {tuple(box)} lies outside of the image")
    return part


def _find(dataset: _core.Dataset, number: int) -> _core.Frame:
    """The frame with that number; numbers ascend with positions, and positions that cannot be read tell theirs to nobody."""
    low, high = 0, len(dataset)
    while low < high:
        middle = (low + high) // 2
        frame, at = None, middle
        while frame is None and at < high:
            try:
                frame = dataset[at]
            except _core.Error:
                at += 1
        if frame is None:
            high = middle
        elif frame.index == number:
            return frame
        elif frame.index < number:
            low = at + 1
        else:
            high = middle
    raise _core.Error(f"frame {number} is not in the recording any more, or cannot be read")


def evidence_crops(folder: Union[str, "os.PathLike[str]"], id: int,
                   margin: float = 0.25) -> List[Tuple[Dict[str, Any], NDArray[np.uint8]]]:
    """Crops of an object's best views, from a run's folder and its recording: a list of (view, (h, w, 3) uint8), the best first."""
    folder = pathlib.Path(folder)
    evidence = _core.explain(folder, id)
    report = json.loads((folder / "report.json").read_text())
    if not report.get("recording"):
        raise _core.Error(f"{folder / 'report.json'}: the run did not write down its recording")
    dataset = _core.open_dataset(report["recording"], report.get("calibration") or None)
    return [(view, crop(_find(dataset, view["frame"]), view["box"], margin)) for view in evidence["best_views"]]
