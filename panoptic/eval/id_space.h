// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// How predictions number the classes of the benchmark, and signs that they number them otherwise than was said.
#pragma once

#include <cstdint>
#include <filesystem>
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

// Throws Error, beginning with the file, if most of the numbers that stand for something (not 0, not below it, not 255 or 65535)
// are no class of that space: then they are of another form, and would be scored as nothing.
void require_classes(const std::filesystem::path& file, const std::vector<std::int64_t>& numbers, IdSpace space);

// Throws Error if most numbers that stand for something are too small to be class * 1000 + instance.
void require_class_and_instance(const std::filesystem::path& file, const std::vector<std::int64_t>& numbers);

// Throws Error if the truth has neither wall nor floor, as one of instances alone, and the prediction has: every stuff class
// would be scored as wrong. One entry per vertex in both.
void require_stuff(const std::string& scene, const std::vector<ClassId>& truth, const std::vector<ClassId>& prediction);

// Lines for the user, each beginning with the scene: a prediction that names no class, or, of labels read as NYU40's, more
// vertices that agree with the truth in another space. One entry per vertex in both.
std::vector<std::string> label_notices(const std::string& scene, const std::vector<ClassId>& truth,
                                       const std::vector<ClassId>& prediction);

// A line if less than a third of the map's vertices lie within 10 cm of the truth's and the other way round, with what may be the
// reason; else nothing.
std::string place_notice(const LabelledMap& map, const ScanTruth& truth);

}  // namespace panoptic
