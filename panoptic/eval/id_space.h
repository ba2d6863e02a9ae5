// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// How predictions number the classes of the benchmark, and signs that they number them otherwise than was said.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "panoptic/evaluation.h"
#include "panoptic/scan_truth.h"

namespace panoptic {

// NYU40's own numbers; 1 to 20 in the order of the benchmark's classes, 0 for none; 0 to 19 in that order, as networks are
// trained, where negative numbers and 255 are none.
enum class IdSpace { kNyu40, kScannet20, kTrain };

// "nyu40", "scannet20", "train". Throws Error for any other name.
IdSpace id_space_of(const std::string& name);

// NYU40's class of a number in that space; kUnknown for a number that is none.
ClassId class_in(std::int64_t id, IdSpace space);

// Lines for the user, each beginning with the scene, where labels read as NYU40's do not look like that: no class at all, mostly
// ids above 40, or more vertices that agree with the truth in another space. One entry per vertex in both.
std::vector<std::string> label_notices(const std::string& scene, const std::vector<ClassId>& truth,
                                       const std::vector<ClassId>& prediction);

// A line if less than a third of the map's vertices lie within 10 cm of the truth's, with what may be the reason; else nothing.
std::string place_notice(const LabelledMap& map, const ScanTruth& truth);

}  // namespace panoptic
