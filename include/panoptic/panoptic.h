// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Everything that a program needs to map a recording: see examples/01_map_a_recording.cpp. Headers of their own have the map
// itself (map.h), map files (map_file.h), questions to a map (query.h), two maps of one place (map_pairs.h), frames as they
// arrive (online.h), which frames were used (frame_statistics.h), stage times (profile.h), how many threads work (parallel.h),
// simulated homes (simulation.h) and scores (evaluation.h, scan_truth.h).
#pragma once

#include "panoptic/error.h"
#include "panoptic/frame.h"
#include "panoptic/labels.h"
#include "panoptic/mapper.h"
#include "panoptic/mesh.h"
#include "panoptic/options.h"
#include "panoptic/outputs.h"
#include "panoptic/predictor.h"
#include "panoptic/segmentation.h"
#include "panoptic/source.h"
