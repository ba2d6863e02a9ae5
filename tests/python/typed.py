# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""A program that mypy must accept, and one mistake that it must find; it is never run."""
from typing import Optional

import numpy as np
from numpy.typing import NDArray

import panoptic as pf


class Network(pf.Predictor):
    def __init__(self) -> None:
        super().__init__("indoor")

    def predict(self, frame: pf.Frame) -> Optional[pf.Segmentation]:
        return pf.Segmentation.from_masks(np.zeros((0, *frame.color.shape[:2]), bool), [], self.labels)


def surface(path: str) -> NDArray[np.float32]:
    mapper = pf.Mapper(pf.Options(map={"voxel_size_m": 0.05}), labels="indoor")
    network = Network()
    for frame in pf.progress(pf.open_dataset(path)):
        if not mapper.add(frame, network.predict(frame)):
            continue
    mapper.finish()
    mapper.add("no frame")  # type: ignore[arg-type]  # the one mistake: mypy warns if this line is none
    return mapper.mesh().vertices
