// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace panoptic {
namespace {

double worth(const ObjectView& view) { return static_cast<double>(view.score) * view.visible_px; }

// Two detections of one object in one frame come only from merged objects; all that tells them apart decides, so that the order
// of merging does not.
bool better(const ObjectView& a, const ObjectView& b) {
  const auto rank = [](const ObjectView& v) {
    return std::tuple(-worth(v), v.frame, v.box.u0, v.box.v0, v.box.u1, v.box.v1, number(v.class_id), v.score);
  };
  return rank(a) < rank(b);
}

}  // namespace

bool BestViews::wants(const ObjectView& view) const { return count_ < kMost || better(view, views_.back()); }

void BestViews::add(const ObjectView& view) {
  if (!wants(view)) return;
  if (count_ < kMost) ++count_;
  std::size_t place = count_ - 1;
  for (; place > 0 && better(view, views_[place - 1]); --place) views_[place] = views_[place - 1];
  views_[place] = view;
}

void BestViews::merge(const BestViews& other) {
  const BestViews theirs = other;  // which may be this
  for (const ObjectView& view : theirs.views()) add(view);
}

VoteHistory::Bin& VoteHistory::bin_of(std::int64_t number) {
  if (!bins_.empty() && bins_.back().number == number) return bins_.back();
  const auto at = std::lower_bound(bins_.begin(), bins_.end(), number, [](const Bin& b, std::int64_t n) { return b.number < n; });
  return at != bins_.end() && at->number == number ? *at : *bins_.insert(at, {number, {}});
}

void VoteHistory::widen() {
  ++log2_frames_per_bin_;
  const std::vector<Bin> narrow = std::exchange(bins_, {});
  for (const Bin& bin : narrow) {
    Bin& wide = bin_of(bin.number >> 1);
    for (const auto& [class_id, count] : bin.votes) wide.votes[class_id] += count;
  }
}

void VoteHistory::add(std::int64_t frame, ClassId class_id) {
  ++bin_of(frame >> log2_frames_per_bin_).votes[class_id];
  while (bins_.size() > kMostBins) widen();
}

void VoteHistory::merge(const VoteHistory& other) {
  VoteHistory theirs = other;
  while (log2_frames_per_bin_ < theirs.log2_frames_per_bin_) widen();
  while (theirs.log2_frames_per_bin_ < log2_frames_per_bin_) theirs.widen();
  for (const Bin& bin : theirs.bins_) {
    Bin& mine = bin_of(bin.number);
    for (const auto& [class_id, count] : bin.votes) mine.votes[class_id] += count;
  }
  while (bins_.size() > kMostBins) widen();
}

void PartHistory::append(const std::vector<ObjectPart>& parts) {
  latest_.insert(latest_.end(), parts.begin(), parts.end());
  if (latest_.size() > kMost) latest_.erase(latest_.begin(), latest_.end() - std::ptrdiff_t{kMost});
}

void PartHistory::add(const ObjectPart& part) {
  ++count_;
  append({part});
}

void PartHistory::merge(const PartHistory& other) {
  count_ += other.count_;
  append(other.latest_);
}

}  // namespace panoptic
