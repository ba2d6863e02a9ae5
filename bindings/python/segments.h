// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "bindings/python/bind.h"
#include "panoptic/labels.h"
#include "panoptic/segmentation.h"

namespace panoptic::python {

// The segments of a frame in any form that Mapper.add takes: None, a Segmentation, (ids, segments), (masks, classes),
// (masks, classes, scores) or a panoptic image. Nobody changes what it returns: values in it are places in lists. Throws Error.
std::shared_ptr<const Segmentation> segmentation_from(const py::handle& object, const LabelSet& labels);

// Throws Error if a segment is of no class of the label set, or a number of it is none.
void require_sound(const Segmentation& segmentation, const LabelSet& labels);

}  // namespace panoptic::python
