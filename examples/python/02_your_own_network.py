# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""A network of your own: whatever gives masks in Python labels the map.

    02_your_own_network.py RECORDING MAP.panoptic

Here a rule stands in its place, so that the example needs no weights: what is red or orange is a cushion. With PyTorch, call your
network in `predict` and hand over `masks.cpu().numpy()`.
"""
import sys
from typing import Optional

import numpy as np

import panoptic as pf

LABELS = pf.LabelSet("mine", [pf.LabelClass(1, "room", is_thing=False), pf.LabelClass(2, "cushion", color=(230, 90, 20))])


class RedThings(pf.Predictor):
    def __init__(self) -> None:
        super().__init__(LABELS)

    def predict(self, frame: pf.Frame) -> Optional[pf.Segmentation]:
        red, green, blue = (frame.color[..., c].astype(int) for c in range(3))
        mask = (red > green + 40) & (red > blue + 40)
        masks = mask[None] if mask.sum() > 500 else np.zeros((0, *mask.shape), bool)
        return pf.Segmentation.from_masks(masks, ["cushion"] * len(masks), self.labels, scores=[0.8] * len(masks),
                                          semantic=np.ones(mask.shape, np.uint8))


def main(recording: str, saved: str) -> None:
    network = RedThings()
    mapper = pf.Mapper(pf.Options(map={"voxel_size_m": 0.04}), labels=network.labels)
    for frame in pf.progress(pf.open_dataset(recording)):
        mapper.add(frame, network.predict(frame))
    mapper.finish()
    mapper.save(saved)
    print(f"{len(mapper.map.objects('cushion'))} red objects in {mapper.frames['labelled']} frames")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
