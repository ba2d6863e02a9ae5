// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Every vote for every label at the surface, without limit, to compare the single label of a voxel with.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "panoptic/frame.h"
#include "panoptic/fusion/registration.h"

namespace panoptic {

class VoteMap {
 public:
  explicit VoteMap(float voxel_size_m) : voxel_size_m_(voxel_size_m) {}

  // Adds one vote per depth pixel, at the voxel that holds its point; `labels` as LabelTracker::assign returns them.
  void add(const Frame& frame, const RegisteredFrame& registered, std::span<const LabelSlot> labels);

  // The label with the most votes (ties: the lower id) in the voxel of the point, else in its 26 neighbours together.
  std::optional<LabelSlot> winner(const Vec3f& world_point) const;

 private:
  using Cell = std::array<std::int32_t, 3>;
  using Votes = std::vector<std::pair<LabelSlot, std::uint32_t>>;
  struct Hash {
    std::size_t operator()(const Cell& cell) const;
  };
  Cell cell_of(const Vec3d& world_point) const;

  double voxel_size_m_;
  std::unordered_map<Cell, Votes, Hash> cells_;
};

}  // namespace panoptic
