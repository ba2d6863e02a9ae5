// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Labels for the vertices of a scan, predicted or true, in the terms of the benchmark.
#pragma once

#include <vector>

#include "panoptic/evaluation.h"

namespace panoptic {

VertexLabels labels_of(const ScanTruth& truth);

// Every thing of the prediction that has an identity, ascending by class and instance. A region with a class but without an
// identity (a map whose label set calls cabinets stuff) is no mask: nobody said that it is one thing.
std::vector<InstanceMask> instance_masks(const LabelledVertices& prediction);

}  // namespace panoptic
