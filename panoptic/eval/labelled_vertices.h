// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Labels for the vertices of a scan, predicted or true, in the terms of the benchmark.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "panoptic/data/scan_truth.h"
#include "panoptic/labels.h"

namespace panoptic {

// One entry per vertex. A segment is all vertices that share both class and instance.
struct VertexLabels {
  std::vector<ClassId> class_id;        // NYU40 number; kUnknown = none
  std::vector<std::uint32_t> instance;  // which one; 0 = no identity

  bool operator==(const VertexLabels&) const = default;
};

// A prediction for the vertices of a scan.
struct LabelledVertices {
  VertexLabels labels;
  std::map<std::uint32_t, double> confidence;  // of an instance; 1 where it is missing
  std::vector<std::uint8_t> reached;           // 1 = the map has a surface there, labelled or not; empty = everywhere
};

// One predicted thing. Masks of one scene may overlap.
struct InstanceMask {
  ClassId class_id = ClassId::kUnknown;
  double confidence = 1;
  std::vector<std::uint32_t> vertices;  // ascending
};

VertexLabels labels_of(const ScanTruth& truth);

// Every thing of the prediction that has an identity, ascending by class and instance. A region with a class but without an
// identity (a map whose label set calls cabinets stuff) is no mask: nobody said that it is one thing.
std::vector<InstanceMask> instance_masks(const LabelledVertices& prediction);

}  // namespace panoptic
