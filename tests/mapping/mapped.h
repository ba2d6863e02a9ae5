// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Maps with their frames, as a map file holds them, made by a mapper.
#pragma once

#include <functional>
#include <optional>
#include <utility>

#include "panoptic/map_pairs.h"
#include "panoptic/mapper.h"
#include "panoptic/mapping/checkpoint.h"

namespace panoptic::test {

struct LabelledView {
  Frame frame;
  Segmentation segmentation;
};

// The map of the views begin, begin + 1 ... end - 1, by way of a file: then it holds all that a file does and nothing else.
inline void map_views(const std::function<LabelledView(int)>& view, int begin, int end, const RunIdentity& run,
                      const LabelSet& labels, const std::filesystem::path& path) {
  Mapper mapper(run.options, labels);
  Checkpoints checkpoints({.path = path, .every_s = 1e9}, run, mapper);
  for (int i = begin; i < end; ++i) {
    const LabelledView v = view(i);
    checkpoints.note(record_of(v.frame, true, mapper.add(v.frame, v.segmentation)));
  }
  mapper.finish();
  checkpoints.finish(mapper, true);
}

}  // namespace panoptic::test
