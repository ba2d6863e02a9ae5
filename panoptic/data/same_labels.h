// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "panoptic/labels.h"

namespace panoptic {

// True if all that a map depends on is the same: everything but names of sets and colours.
inline bool same_labels(const LabelSet& a, const LabelSet& b) {
  const auto same = [](const LabelClass& x, const LabelClass& y) {
    return x.id == y.id && x.name == y.name && x.is_thing == y.is_thing && x.max_size_m == y.max_size_m &&
           x.is_support == y.is_support && x.is_mobile == y.is_mobile;
  };
  return std::equal(a.classes().begin(), a.classes().end(), b.classes().begin(), b.classes().end(), same);
}

}  // namespace panoptic
