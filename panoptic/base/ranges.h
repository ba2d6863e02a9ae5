// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Loops over index ranges that run on one thread or on all: many small problems side by side take one thread each, a single
// large one takes all. The ranges do not depend on the thread count.
#pragma once

#include <algorithm>
#include <cstddef>

#include "panoptic/parallel.h"

namespace panoptic {

struct Ranges {
  bool parallel = false;

  // body(begin, end) for consecutive ranges of at most `grain` that cover [0, count).
  template <typename Body>
  void run(std::size_t count, std::size_t grain, const Body& body) const {
    const std::size_t pieces = (count + grain - 1) / grain;
    const auto piece = [&](std::size_t i) { body(i * grain, std::min(count, (i + 1) * grain)); };
    if (parallel) {
      parallel_for(pieces, piece);
    } else {
      for (std::size_t i = 0; i < pieces; ++i) piece(i);
    }
  }
};

}  // namespace panoptic
