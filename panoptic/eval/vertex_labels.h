// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Carries labels from a map to the vertices of a scan: every vertex of the truth takes the labels of the map's nearest vertex.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "panoptic/evaluation.h"

namespace panoptic {

constexpr double kReach_voxels = 2;  // vertices of the truth farther from the map are unknown

// NYU40's class for a class name of a map: NYU40's own names, then the everyday names of our label sets and of COCO
// (docs/evaluation.md has the table). Nothing for a name that is neither.
std::optional<ClassId> nyu40_of_class_name(std::string_view name);

// One line for every class of the label set that has no NYU40 counterpart and counts as otherprop (outside the benchmark).
std::vector<std::string> foreign_classes(const LabelSet& labels);

// The confidence in an object: its class probability (Eq. 12), less if it was seen in few frames, p * n / (n + 10).
double object_confidence(double class_probability, double observations);

// The labels of the map at these points. If two map vertices are at the same distance, the one with the lower index counts.
LabelledVertices carry_labels(const LabelledMap& map, const std::vector<Vec3f>& points);

}  // namespace panoptic
