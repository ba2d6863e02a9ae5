// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/benchmark/vote_map.h"

#include <algorithm>
#include <cmath>

#include "panoptic/map/block_key.h"
#include "panoptic/map/voxel_grid.h"
#include "panoptic/voxel_map.h"

namespace panoptic {
namespace {

void count(std::vector<std::pair<LabelSlot, std::uint32_t>>& votes, LabelSlot id, std::uint32_t by) {
  const auto entry = std::ranges::find(votes, id, [](const auto& vote) { return vote.first; });
  if (entry == votes.end()) {
    votes.emplace_back(id, by);
  } else {
    entry->second += by;
  }
}

}  // namespace

std::size_t VoteMap::Hash::operator()(const Cell& cell) const {
  std::uint64_t key = 0;
  for (const std::int32_t coordinate : cell) key = mixed(key ^ static_cast<std::uint32_t>(coordinate)) * 3;
  return key;
}

VoteMap::Cell VoteMap::cell_of(const Vec3d& world_point) const {
  const auto coordinate = [&](double metres) { return static_cast<std::int32_t>(std::floor(metres / voxel_size_m_)); };
  return {coordinate(world_point.x()), coordinate(world_point.y()), coordinate(world_point.z())};
}

void VoteMap::add(const Frame& frame, const RegisteredFrame& registered, std::span<const LabelSlot> labels) {
  for (int v = 0; v < registered.height; ++v) {
    for (int u = 0; u < registered.width; ++u) {
      const std::size_t i = registered.index(v) + static_cast<std::size_t>(u);
      const float depth = registered.depth[i];
      if (depth <= 0 || labels[i] == LabelSlot::kNoVote) continue;
      const Vec3d point = frame.world_from_camera * back_project(frame.depth_camera, u, v, static_cast<double>(depth));
      count(cells_[cell_of(point)], labels[i], 1);
    }
  }
}

std::optional<LabelSlot> VoteMap::winner(const Vec3f& world_point) const {
  const Cell center = cell_of(world_point.cast<double>());
  Votes votes;
  if (const auto cell = cells_.find(center); cell != cells_.end()) votes = cell->second;
  for (int n = 0; n < kNeighbours && cells_.find(center) == cells_.end(); ++n) {
    const BlockIndex step = step_to(n);
    const auto cell = cells_.find({center[0] + step.x, center[1] + step.y, center[2] + step.z});
    if (cell == cells_.end()) continue;
    for (const auto& [id, by] : cell->second) count(votes, id, by);
  }
  if (votes.empty()) return std::nullopt;
  const auto better = [](const auto& a, const auto& b) { return a.second != b.second ? a.second < b.second : a.first > b.first; };
  return std::ranges::max_element(votes, better)->first;
}

}  // namespace panoptic
