// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// From true masks to what networks give. Presets: "oracle", "good", "maskrcnn" (single-frame PQ about 40), "poor".
#pragma once

#include <cstdint>
#include <string>

#include "panoptic/base/config.h"
#include "panoptic/data/labels.h"
#include "panoptic/data/segmentation.h"
#include "panoptic/sim/renderer.h"

namespace panoptic {

// Fields, ranges and their meaning: prediction_noise.cpp. The defaults are the oracle.
struct PredictionNoise;

}  // namespace panoptic
