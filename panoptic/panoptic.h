// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Everything that a program needs to map a recording: see examples/01_map_a_recording.cpp.
#pragma once

// clang-format off
#include "panoptic/base/error.h"
#include "panoptic/base/parallel.h"
#include "panoptic/data/frame.h"
#include "panoptic/data/labels.h"
#include "panoptic/data/mesh.h"
#include "panoptic/data/object_shapes.h"
#include "panoptic/data/segmentation.h"
#include "panoptic/session/open_dataset.h"
#include "panoptic/io/glb.h"
#include "panoptic/io/mesh_io.h"
#include "panoptic/io/views.h"
#include "panoptic/map/map_file.h"
#include "panoptic/map/object_registry.h"
#include "panoptic/map/voxel_map.h"
#include "panoptic/predict/predictor.h"
#include "panoptic/session/checkpoint.h"
#include "panoptic/session/map_diff.h"
#include "panoptic/session/map_merging.h"
#include "panoptic/session/map_query.h"
#include "panoptic/session/options.h"
#include "panoptic/session/outputs.h"
#include "panoptic/session/session.h"
// clang-format on
