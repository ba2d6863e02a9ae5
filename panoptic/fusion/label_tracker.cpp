// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/label_tracker.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace panoptic {
namespace {

constexpr std::uint16_t kNoColumn = 65535;
constexpr std::size_t kIds = 65536;

}  // namespace

Fields fields(TrackerOptions& o) {
  return {{"iou_threshold", &o.iou_threshold, "a segment joins an object of the map if their IoU is above this (Eq. 4)",
           in_range(0, 1)},
          {"trust_map",
           &o.trust_map,
           "pixels that say less than the map knows (unknown, a table under an unnamed thing) confirm it",
           {}}};
}

LabelTracker::LabelTracker(const TrackerOptions& options, LabelSet labels)
    : options_(options), labels_(std::move(labels)), column_of_id_(kIds, kNoColumn) {}

// Neighbouring pixels mostly repeat the same pair, so runs are counted and added at their end.
void LabelTracker::count_overlaps(const RegisteredFrame& registered, std::size_t segment_count,
                                  std::span<const PanopticId> reference) {
  for (const PanopticId id : column_id_) column_of_id_[number(id)] = kNoColumn;
  column_id_.clear();
  reference_area_.clear();
  segment_area_.assign(segment_count, 0);
  std::vector<std::vector<std::uint32_t>> columns;  // per reference object: overlap with each segment
  const auto column = [&](PanopticId id) -> std::size_t {
    std::uint16_t& c = column_of_id_[number(id)];
    if (c == kNoColumn) {
      c = static_cast<std::uint16_t>(column_id_.size());
      column_id_.push_back(id);
      reference_area_.push_back(0);
      columns.emplace_back(segment_count, 0);
    }
    return c;
  };
  const auto add_run = [&](std::uint16_t segment, PanopticId id, std::uint32_t run) {
    if (segment == RegisteredFrame::kNoSegment) return;
    if (segment > 0) segment_area_[segment - 1U] += run;
    if (!labels_.is_object(id)) return;
    const std::size_t c = column(id);
    reference_area_[c] += run;
    if (segment > 0) columns[c][segment - 1U] += run;
  };
  std::size_t begin = 0;
  for (std::size_t i = 1; i <= reference.size(); ++i) {
    if (i < reference.size() && registered.segment[i] == registered.segment[begin] && reference[i] == reference[begin]) continue;
    add_run(registered.segment[begin], reference[begin], static_cast<std::uint32_t>(i - begin));
    begin = i;
  }
  overlap_.assign(segment_count * column_id_.size(), 0);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    for (std::size_t s = 0; s < segment_count; ++s) overlap_[s * columns.size() + c] = columns[c][s];
  }
  column_taken_.assign(column_id_.size(), false);
}

// Eq. 4: the free object with the highest IoU above the threshold; ties go to the lower id.
PanopticId LabelTracker::best_match(std::size_t segment) const {
  PanopticId best = PanopticId::kUnknown;
  double best_iou = options_.iou_threshold;
  for (std::size_t c = 0; c < column_id_.size(); ++c) {
    const double shared = overlap_[segment * column_id_.size() + c];
    if (column_taken_[c] || shared == 0) continue;
    const double both = static_cast<double>(segment_area_[segment]) + reference_area_[c] - shared;
    const double iou = shared / both;
    const bool tie_for_lower_id = iou == best_iou && best != PanopticId::kUnknown && column_id_[c] < best;
    if (iou > best_iou || tie_for_lower_id) {
      best = column_id_[c];
      best_iou = iou;
    }
  }
  return best;
}

const std::vector<PanopticId>& LabelTracker::assign(const RegisteredFrame& registered, std::span<const Segment> segments,
                                                    std::span<const PanopticId> reference, std::int64_t frame,
                                                    ObjectRegistry& objects) {
  count_overlaps(registered, segments.size(), reference);
  std::vector<std::size_t> order(segments.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return segment_area_[a] > segment_area_[b]; });

  id_of_value_.assign(segments.size() + 1, PanopticId::kUnknown);
  for (const std::size_t s : order) {
    const Segment& segment = segments[s];
    PanopticId& id = id_of_value_[s + 1];
    if (labels_.is_stuff(segment.class_id) || segment.is_whole_class) id = LabelSet::of_class(segment.class_id);
    if (!labels_.is_thing(segment.class_id) || segment.is_whole_class || segment_area_[s] == 0) continue;
    id = best_match(s);
    if (id != PanopticId::kUnknown) {
      column_taken_[column_of_id_[number(id)]] = true;
    } else {
      id = objects.create().value_or(PanopticId::kNoVote);
    }
    if (id != PanopticId::kNoVote) objects.observe(id, segment, frame);
  }
  label_pixels(registered, segments, reference, objects);
  return result_;
}

// Of a value of RegisteredFrame::segment, where the map has an object of a known class.
bool LabelTracker::says_less(std::size_t value, ClassId known, std::span<const Segment> segments) const {
  if (value == 0) return known == ClassId::kUnknown;
  const Segment& segment = segments[value - 1];
  if (known == ClassId::kUnknown) return labels_.is_support(segment.class_id);
  return segment.is_whole_class && segment.class_id == known;
}

void LabelTracker::label_pixels(const RegisteredFrame& registered, std::span<const Segment> segments,
                                std::span<const PanopticId> reference, const ObjectRegistry& objects) {
  const std::size_t columns = column_id_.size();
  std::vector<bool> confirms((segments.size() + 1) * columns, false);
  for (std::size_t c = 0; options_.trust_map && c < columns; ++c) {
    const ClassId known = objects.class_of(column_id_[c]);
    for (std::size_t v = 0; v <= segments.size(); ++v) confirms[v * columns + c] = says_less(v, known, segments);
  }
  result_.assign(registered.segment.size(), PanopticId::kNoVote);
  for (std::size_t i = 0; i < result_.size(); ++i) {
    const std::uint16_t value = registered.segment[i];
    if (value == RegisteredFrame::kNoSegment) continue;
    result_[i] = id_of_value_[value];
    const PanopticId known = i < reference.size() ? reference[i] : PanopticId::kUnknown;
    const std::size_t column = column_of_id_[number(known)];
    if (column != kNoColumn && confirms[value * columns + column]) result_[i] = known;
  }
}

}  // namespace panoptic
