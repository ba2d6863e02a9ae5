# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""A recording and predictions in, a labelled scene and a map file out.

    01_map_a_recording.py RECORDING PREDICTIONS SCENE.glb MAP.panoptic
"""
import sys

import panoptic as pf


def main(recording: str, predictions: str, scene: str, saved: str) -> None:
    predictor = pf.file_predictor(predictions)  # or pf.make_predictor(pf.Options(networks={"semantic": "....toml"}))
    mapper = pf.Mapper(pf.Options(map={"voxel_size_m": 0.03}), labels=predictor.labels)
    for frame in pf.progress(pf.open_dataset(recording)):
        outcome = mapper.add(frame, predictor.predict(frame))
        if not outcome:
            print(f"frame {frame.index}: {outcome.reason}")
    mapper.finish()
    mapper.mesh().save(scene, up=mapper.up)
    mapper.save(saved)
    print(f"{mapper.frames['used']} frames, map {mapper.map_hash()}")
    for item in mapper.map.objects():
        print(item)


if __name__ == "__main__":
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    main(*sys.argv[1:])
