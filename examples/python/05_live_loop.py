# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Maps live: a thread pushes frames as the callback of a robot's driver would, and the map is looked at while it grows.

    05_live_loop.py RECORDING PREDICTIONS
"""
import sys
import threading
import time

import panoptic as pf


def camera(recording: str, pipeline: pf.OnlinePipeline) -> None:
    """Stands for the driver: calls at the times of the frames' stamps, or 30 times a second where there are none."""
    dataset = pf.open_dataset(recording)
    first_s, begin = dataset[0].time_s, time.monotonic()
    for count, frame in enumerate(dataset):
        due_s = frame.time_s - first_s or count / 30
        time.sleep(max(0, begin + due_s - time.monotonic()))
        taken = pipeline.push(depth=frame.depth, color=frame.color, K=frame.depth_camera, color_K=frame.color_camera,
                              color_from_depth=frame.color_from_depth, pose=frame.pose, index=frame.index, time_s=frame.time_s,
                              depth_weight=frame.depth_weight)
        if not taken:
            print(f"frame {frame.index} was dropped: fusion is behind")


def main(recording: str, predictions: str) -> None:
    predictor = pf.file_predictor(predictions)
    mapper = pf.Mapper(pf.Options(map={"voxel_size_m": 0.05}, online={"mesh_every_s": 0.2}), labels=predictor.labels)
    pipeline = pf.OnlinePipeline(mapper, predictor)
    driver = threading.Thread(target=camera, args=(recording, pipeline))
    driver.start()
    while driver.is_alive():
        driver.join(timeout=0.3)
        snapshot = pipeline.snapshot()
        print(f"frame {snapshot.frame}: {len(snapshot.mesh.triangles)} triangles, {len(snapshot.objects)} objects")
    report = pipeline.finish()
    print(f"{report['read']} frames: {report['used']} used, {report['labelled']} of them labelled, {report['dropped']} dropped")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
