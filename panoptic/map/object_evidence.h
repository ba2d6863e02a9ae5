// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Why the map takes an object for what it is, in bounded memory per object: the detections that show it best, which class the
// detections of each stretch of time voted for, and which objects turned out to be parts of it. The first two depend on the
// detections alone, not on their order.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "panoptic/data/labels.h"

namespace panoptic {

// Pixels u0 <= u < u1, v0 <= v < v1; empty where u0 >= u1.
struct PixelBox {
  int u0 = 0;
  int v0 = 0;
  int u1 = 0;
  int v1 = 0;

  bool operator==(const PixelBox&) const = default;
};

// One detection of an object.
struct ObjectView {
  std::int64_t frame = 0;
  ClassId class_id = ClassId::kUnknown;  // what it was taken for
  float score = 0;
  std::uint32_t visible_px = 0;  // of the depth image
  PixelBox box;                  // of the mask, in the colour image

  bool operator==(const ObjectView&) const = default;
};

// The detections with the largest score * visible_px, best first; ties go to the earlier frame.
class BestViews {
 public:
  static constexpr std::size_t kMost = 3;

  // Whether add would keep it.
  bool wants(const ObjectView& view) const;
  void add(const ObjectView& view);
  void merge(const BestViews& other);
  std::span<const ObjectView> views() const { return {views_.data(), count_}; }

  bool operator==(const BestViews&) const = default;

 private:
  std::array<ObjectView, kMost> views_;
  std::size_t count_ = 0;
};

// Votes per class in bins of 2^k frames, k as small as at most kMostBins bins that hold votes allow. Bin n holds the frames
// n * 2^k to (n + 1) * 2^k - 1, whenever the object was first seen, so that histories can be merged.
class VoteHistory {
 public:
  static constexpr std::size_t kMostBins = 16;
  struct Bin {
    std::int64_t number = 0;
    std::map<ClassId, std::uint64_t> votes;

    bool operator==(const Bin&) const = default;
  };

  VoteHistory() = default;
  // As bins() and log2_frames_per_bin() of another one told. REQUIRES what they guarantee.
  VoteHistory(std::vector<Bin> bins, int log2_frames_per_bin)
      : bins_(std::move(bins)), log2_frames_per_bin_(log2_frames_per_bin) {}

  void add(std::int64_t frame, ClassId class_id);
  void merge(const VoteHistory& other);

  const std::vector<Bin>& bins() const { return bins_; }  // ascending, none empty
  static constexpr int kMostLog2 = 60;                    // 16 bins of that width hold every frame number there is
  int log2_frames_per_bin() const { return log2_frames_per_bin_; }
  std::uint64_t frames_per_bin() const { return std::uint64_t{1} << log2_frames_per_bin_; }
  std::int64_t first_frame(const Bin& bin) const { return bin.number * static_cast<std::int64_t>(frames_per_bin()); }

  bool operator==(const VoteHistory&) const = default;

 private:
  Bin& bin_of(std::int64_t number);
  void widen();

  std::vector<Bin> bins_;
  int log2_frames_per_bin_ = 0;  // at most kMostLog2
};

// Another object that turned out to be a part of this one, and the frame after which that was found.
struct ObjectPart {
  PanopticId id = PanopticId::kUnknown;
  std::int64_t frame = 0;

  bool operator==(const ObjectPart&) const = default;
};

// How many parts were found, and the latest of them.
class PartHistory {
 public:
  static constexpr std::size_t kMost = 64;

  PartHistory() = default;
  // As count() and latest() of another one told. REQUIRES what they guarantee.
  PartHistory(std::uint64_t count, std::vector<ObjectPart> latest) : count_(count), latest_(std::move(latest)) {}

  void add(const ObjectPart& part);
  // Those of an object that is a part itself.
  void merge(const PartHistory& other);

  std::uint64_t count() const { return count_; }
  const std::vector<ObjectPart>& latest() const { return latest_; }  // in the order in which they were added, at most kMost

  bool operator==(const PartHistory&) const = default;

 private:
  void append(const std::vector<ObjectPart>& parts);

  std::uint64_t count_ = 0;
  std::vector<ObjectPart> latest_;
};

}  // namespace panoptic
