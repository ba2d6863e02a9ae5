// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Keeps object ids the same from frame to frame by asking the map (Eq. 3-5), and gathers class evidence (Eq. 12).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "panoptic/base/config.h"
#include "panoptic/fusion/label_runs.h"
#include "panoptic/fusion/registration.h"
#include "panoptic/objects.h"
#include "panoptic/options.h"
#include "panoptic/segmentation.h"

namespace panoptic {

Fields fields(TrackerOptions& options);

class LabelTracker {
 public:
  LabelTracker(const TrackerOptions& options, LabelSet labels);

  // Gives labels to segments (Eq. 3-5): every thing segment gets the id of the object in the map that it overlaps best, if the
  // IoU exceeds the threshold, else a new id; larger masks choose first, and no id is taken twice. Stuff keeps its class
  // number. IoU counts the pixels that have both a depth reading and a segment (the reference exists nowhere else). Evidence
  // goes to `objects` (Eq. 12). Returns the label per depth pixel plus the extra pixel of RegisteredFrame; kNoVote, the ignore
  // label, where the frame says nothing. Good until the next call, as are the two below. Not thread-safe; bands of pixels run
  // in parallel, and the result is the same at any number of threads.
  const std::vector<LabelSlot>& assign(const RegisteredFrame& registered, std::span<const Segment> segments,
                                       std::span<const LabelSlot> reference, std::int64_t frame, ObjectRegistry& objects);

  // The steps of assign, for whoever knows ids already. `compare` counts overlaps; then best_match is the free object of Eq. 4
  // for a segment, or kUnknown, and `take` gives an object away; `label` ends the call as assign does. Nothing is observed.
  void compare(const RegisteredFrame& registered, std::size_t segment_count, std::span<const LabelSlot> reference);
  LabelSlot best_match(std::size_t segment) const;
  void take(LabelSlot object);
  const std::vector<LabelSlot>& label(const RegisteredFrame& registered, std::span<const Segment> segments,
                                      std::span<const LabelSlot> ids, const ObjectRegistry& objects);
  // The segments of the frame that is compared, the largest first.
  std::vector<std::size_t> by_area() const;

  // For each segment of that call, its id, and its pixels with a depth reading.
  std::span<const LabelSlot> segment_ids() const { return std::span(id_of_value_).subspan(1); }
  std::span<const std::uint32_t> segment_areas_px() const { return segment_area_; }

 private:
  // Pixels are worked in this many bands: fixed, so that nothing depends on the thread count.
  static constexpr std::size_t kBands = 16;

  void find_bands(const RegisteredFrame& registered, std::span<const LabelSlot> reference);
  void count_overlaps(std::size_t segment_count);
  std::size_t column_of(LabelSlot object, std::size_t segment_count);
  bool says_less(std::size_t value, ClassId known, std::span<const Segment> segments) const;
  void label_pixels(std::span<const Segment> segments, const ObjectRegistry& objects);

  TrackerOptions options_;
  LabelSet labels_;
  std::vector<LabelSlot> result_;
  std::vector<LabelSlot> id_of_value_ = {LabelSlot::kUnknown};  // by value of RegisteredFrame::segment
  std::array<std::vector<LabelRun>, kBands> runs_;
  // Co-occurrence of segments and objects seen in the reference (columns, in order of first appearance), column by column.
  std::vector<std::uint32_t> overlap_;
  std::vector<std::uint32_t> segment_area_;
  std::vector<std::uint32_t> reference_area_;
  std::vector<LabelSlot> column_id_;
  std::vector<bool> column_taken_;
  std::vector<std::uint16_t> column_of_id_;
};

}  // namespace panoptic
