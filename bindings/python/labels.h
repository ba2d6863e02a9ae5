// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "bindings/python/bind.h"
#include "panoptic/labels.h"

namespace panoptic::python {

// A LabelSet, or one by its name or path; `otherwise` for None. Throws Error.
LabelSet labels_from(const py::handle& object, const std::string& otherwise);

// Whether both have the same classes under the same numbers.
bool same_classes(const LabelSet& a, const LabelSet& b);

// A class by its number or, with a label set, by its name. Throws Error if it is none, or none of the label set.
ClassId class_from(const py::handle& object, const LabelSet* labels);
ClassId class_numbered(std::int64_t id, const LabelSet* labels);

}  // namespace panoptic::python
