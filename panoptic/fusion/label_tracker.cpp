// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/label_tracker.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "panoptic/parallel.h"

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

void LabelTracker::find_bands(const RegisteredFrame& registered, std::span<const LabelSlot> reference) {
  const std::size_t pixels = reference.size();
  parallel_for(kBands, [&](std::size_t band) {
    const PixelRange range{static_cast<std::uint32_t>(pixels * band / kBands),
                           static_cast<std::uint32_t>(pixels * (band + 1) / kBands)};
    find_runs(registered.segment, reference, range, runs_[band]);
  });
}

std::size_t LabelTracker::column_of(LabelSlot object, std::size_t segment_count) {
  std::uint16_t& column = column_of_id_[number(object)];
  if (column == kNoColumn) {
    column = static_cast<std::uint16_t>(column_id_.size());
    column_id_.push_back(object);
    reference_area_.push_back(0);
    overlap_.resize(column_id_.size() * segment_count, 0);
  }
  return column;
}

void LabelTracker::count_overlaps(std::size_t segment_count) {
  for (const LabelSlot id : column_id_) column_of_id_[number(id)] = kNoColumn;
  column_id_.clear();
  reference_area_.clear();
  overlap_.clear();
  segment_area_.assign(segment_count, 0);
  for (const std::vector<LabelRun>& band : runs_) {
    for (std::size_t r = 0; r + 1 < band.size(); ++r) {
      const LabelRun& run = band[r];
      const std::uint32_t pixels = band[r + 1].begin - run.begin;
      if (run.segment == RegisteredFrame::kNoSegment) continue;
      if (run.segment > 0) segment_area_[run.segment - 1U] += pixels;
      if (!labels_.is_object(run.reference)) continue;
      const std::size_t column = column_of(run.reference, segment_count);
      reference_area_[column] += pixels;
      if (run.segment > 0) overlap_[column * segment_count + run.segment - 1U] += pixels;
    }
  }
  column_taken_.assign(column_id_.size(), false);
}

// Eq. 4: the free object with the highest IoU above the threshold; ties go to the lower id.
LabelSlot LabelTracker::best_match(std::size_t segment) const {
  LabelSlot best = LabelSlot::kUnknown;
  double best_iou = options_.iou_threshold;
  for (std::size_t c = 0; c < column_id_.size(); ++c) {
    const double shared = overlap_[c * segment_area_.size() + segment];
    if (column_taken_[c] || shared == 0) continue;
    const double both = static_cast<double>(segment_area_[segment]) + reference_area_[c] - shared;
    const double iou = shared / both;
    const bool tie_for_lower_id = iou == best_iou && best != LabelSlot::kUnknown && column_id_[c] < best;
    if (iou > best_iou || tie_for_lower_id) {
      best = column_id_[c];
      best_iou = iou;
    }
  }
  return best;
}

void LabelTracker::compare(const RegisteredFrame& registered, std::size_t segment_count, std::span<const LabelSlot> reference) {
  find_bands(registered, reference);
  count_overlaps(segment_count);
}

void LabelTracker::take(LabelSlot object) {
  const std::uint16_t column = column_of_id_[number(object)];
  if (column != kNoColumn) column_taken_[column] = true;
}

std::vector<std::size_t> LabelTracker::by_area() const {
  std::vector<std::size_t> order(segment_area_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return segment_area_[a] > segment_area_[b]; });
  return order;
}

const std::vector<LabelSlot>& LabelTracker::assign(const RegisteredFrame& registered, std::span<const Segment> segments,
                                                   std::span<const LabelSlot> reference, std::int64_t frame,
                                                   ObjectRegistry& objects) {
  compare(registered, segments.size(), reference);
  std::vector<LabelSlot> ids(segments.size(), LabelSlot::kUnknown);
  for (const std::size_t s : by_area()) {
    const Segment& segment = segments[s];
    LabelSlot& id = ids[s];
    if (labels_.is_stuff(segment.class_id) || segment.is_whole_class) id = LabelSet::of_class(segment.class_id);
    if (!labels_.is_thing(segment.class_id) || segment.is_whole_class || segment_area_[s] == 0) continue;
    id = best_match(s);
    if (id != LabelSlot::kUnknown) {
      take(id);
    } else {
      id = objects.create(frame).value_or(LabelSlot::kNoVote);
    }
    if (id != LabelSlot::kNoVote) objects.observe(id, segment, frame);
  }
  return label(registered, segments, ids, objects);
}

const std::vector<LabelSlot>& LabelTracker::label(const RegisteredFrame& registered, std::span<const Segment> segments,
                                                  std::span<const LabelSlot> ids, const ObjectRegistry& objects) {
  id_of_value_.assign(1, LabelSlot::kUnknown);
  id_of_value_.insert(id_of_value_.end(), ids.begin(), ids.end());
  const std::size_t pixels = runs_.back().back().begin;  // where the last run ends
  result_.resize(registered.segment.size());
  std::fill(result_.begin() + static_cast<std::ptrdiff_t>(pixels), result_.end(), LabelSlot::kNoVote);
  label_pixels(segments, objects);
  return result_;
}

// True if a value of RegisteredFrame::segment says less than the map, which has an object of a known class there.
bool LabelTracker::says_less(std::size_t value, ClassId known, std::span<const Segment> segments) const {
  if (value == 0) return known == ClassId::kUnknown;
  const Segment& segment = segments[value - 1];
  if (known == ClassId::kUnknown) return labels_.is_support(segment.class_id);
  return segment.is_whole_class && segment.class_id == known;
}

// A run says one thing: what its segment is, or what the map knows where that says more.
void LabelTracker::label_pixels(std::span<const Segment> segments, const ObjectRegistry& objects) {
  const std::size_t columns = column_id_.size();
  std::vector<std::uint8_t> confirms((segments.size() + 1) * columns, 0);
  for (std::size_t c = 0; options_.trust_map && c < columns; ++c) {
    const ClassId known = objects.class_of(column_id_[c]);
    for (std::size_t v = 0; v <= segments.size(); ++v) confirms[v * columns + c] = says_less(v, known, segments) ? 1 : 0;
  }
  const auto label_of = [&](const LabelRun& run) {
    if (run.segment == RegisteredFrame::kNoSegment) return LabelSlot::kNoVote;
    const std::size_t column = column_of_id_[number(run.reference)];
    if (column != kNoColumn && confirms[run.segment * columns + column] != 0) return run.reference;
    return id_of_value_[run.segment];
  };
  parallel_for(kBands, [&](std::size_t band) {
    const std::vector<LabelRun>& runs = runs_[band];
    for (std::size_t r = 0; r + 1 < runs.size(); ++r) {
      std::fill(result_.begin() + runs[r].begin, result_.begin() + runs[r + 1].begin, label_of(runs[r]));
    }
  });
}

}  // namespace panoptic
