# SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
# SPDX-License-Identifier: Apache-2.0
"""Online volumetric panoptic mapping: posed RGB-D frames go in, a 3D map comes out in which every point knows what it is and which one.

    import panoptic as pf
    mapper = pf.Mapper(pf.Options(map={"voxel_size_m": 0.03}), labels="indoor")
    for frame in pf.open_dataset("recording/"):
        mapper.add(frame, predictor.predict(frame))
    mapper.finish()
    mapper.mesh().save("room.glb")

Lengths are in metres; camera axes x right, y down, z forward; poses are world_from_camera. docs/python.md has the whole story.
"""
from ._core import (Block, Camera, Dataset, Error, Evaluation, Frame, Frames, LabelClass, LabelSet, Map, MapObject, Mapper, Mesh,
                    OnlinePipeline, Options, Outcome, PointAnswer, Predictor, ScanTruth, Segment, Segmentation, Snapshot, diff_maps,
                    evaluate, explain, file_predictor, load_map, make_predictor, merge_maps, open_dataset, read_ply,
                    read_scan_truth, set_threads, simulate, threads)
from ._evidence import crop, evidence_crops
from ._progress import progress

__all__ = ["Block", "Camera", "Dataset", "Error", "Evaluation", "Frame", "Frames", "LabelClass", "LabelSet", "Map", "MapObject",
           "Mapper", "Mesh", "OnlinePipeline", "Options", "Outcome", "PointAnswer", "Predictor", "ScanTruth", "Segment",
           "Segmentation", "Snapshot", "crop", "diff_maps", "evaluate", "evidence_crops", "explain", "file_predictor", "load_map",
           "make_predictor", "merge_maps", "open_dataset", "progress", "read_ply", "read_scan_truth", "set_threads", "simulate",
           "threads"]
