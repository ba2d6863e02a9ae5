// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// One predictor of several, each for the frames of its own recording.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "panoptic/predictor.h"

namespace panoptic {

// The frames from `first_number` up to the next one's.
struct NumberedPredictor {
  std::int64_t first_number = 0;         // the frame that is its frame 0
  std::string name;                      // for messages
  std::unique_ptr<Predictor> predictor;  // nullptr: these frames have no predictions
};

// `predictors`: ascending by number, at least one of them not nullptr. Throws Error if their label sets are not the same.
std::unique_ptr<Predictor> join_predictors(std::vector<NumberedPredictor> predictors);

}  // namespace panoptic
