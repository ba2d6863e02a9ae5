// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Frames of a recording by their numbers, for corrections of poses.
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "panoptic/map_file.h"
#include "panoptic/source.h"

namespace panoptic {

// The dataset must outlive it. `read` may be called from any thread while nothing is noted.
class FrameFinder {
 public:
  explicit FrameFinder(const Dataset& dataset) : dataset_(&dataset) {}

  void note(std::int64_t frame, std::size_t position) { position_of_[frame] = position; }
  // The frames that a run over this range has read.
  void note(const std::vector<FrameRecord>& records, FrameRange range) {
    for (const FrameRecord& record : records) {
      note(record.frame, range.begin + static_cast<std::size_t>(record.position) * range.step);
    }
  }

  ReadResult read(std::int64_t frame) const {
    const auto position = position_of_.find(frame);
    if (position == position_of_.end()) return {std::nullopt, {frame, "it is not among the frames of the recording"}};
    if (position->second >= dataset_->size()) return {std::nullopt, {frame, "the recording ends before it"}};
    ReadResult result = dataset_->read(position->second);
    if (result.frame && result.frame->index != frame) return {std::nullopt, {frame, "the recording has another frame there"}};
    return result;
  }

 private:
  const Dataset* dataset_;
  std::unordered_map<std::int64_t, std::size_t> position_of_;
};

}  // namespace panoptic
