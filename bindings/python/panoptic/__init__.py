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
from ._core import (AgentSize, Block, Camera, CameraPose, CameraTracker, Dataset, DistanceField, Error, Evaluation, FloorGrids,
                    FloorPath, Frame, Frames, FreeSpace, HomePlan, LabelClass, LabelSet, Map, MapObject, Mapper, Mesh,
                    NavigationMesh, OnlinePipeline, Options, Outcome, PointAnswer, Predictor, ScanTruth, Segment, Segmentation,
                    Snapshot, UpFrame, diff_maps, evaluate, explain, file_predictor, floor_grids, list_bag, load_map,
                    make_predictor, merge_maps, open_dataset, plan_home, read_corrected_poses, read_ply, read_pose_updates,
                    read_scan_truth, read_trajectory, score_trajectory, set_threads, simulate, threads, up_frame, write_plan)
from ._evidence import crop, evidence_crops
from ._progress import progress
from ._space import FREE, OCCUPIED, UNKNOWN

__all__ = ["AgentSize", "Block", "Camera", "CameraPose", "CameraTracker", "Dataset", "DistanceField", "Error", "Evaluation", "FREE",
           "FloorGrids", "FloorPath", "Frame", "Frames", "FreeSpace", "HomePlan", "LabelClass", "LabelSet", "Map", "MapObject",
           "Mapper", "Mesh", "NavigationMesh", "OCCUPIED", "OnlinePipeline", "Options", "Outcome", "PointAnswer", "Predictor",
           "ScanTruth", "Segment", "Segmentation", "Snapshot", "UNKNOWN", "UpFrame", "crop", "diff_maps", "evaluate",
           "evidence_crops", "explain", "file_predictor", "floor_grids", "list_bag", "load_map", "make_predictor", "merge_maps",
           "open_dataset", "plan_home", "progress", "read_corrected_poses", "read_ply", "read_pose_updates", "read_scan_truth",
           "read_trajectory", "score_trajectory", "set_threads", "simulate", "threads", "up_frame", "write_plan"]
