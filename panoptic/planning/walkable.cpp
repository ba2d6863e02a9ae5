// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "panoptic/planning/columns.h"

namespace panoptic {
namespace {

using Spot = Eigen::Vector2i;

constexpr std::array<std::array<int, 2>, 8> kAround = {{{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 1}, {-1, 1}, {-1, -1}, {1, -1}}};
constexpr std::size_t kSides = 4;  // of those around, the ones that share an edge

// Works on one set of columns for one agent.
class Walkable {
 public:
  Walkable(SolidColumns& columns, const AgentSize& agent) : columns_(columns), agent_(agent) {}

  // Low things beside floor, on which the agent steps, are floor too: a doorstep, a cable.
  void add_low_steps() {
    std::vector<SolidSpan*> low;
    for (std::size_t column = 0; column < columns_.grid.count(); ++column) {
      for (SolidSpan& span : columns_.of(column)) {
        if (!span.is_floor && has_floor_beside(columns_.grid.at(column), span.top_m)) low.push_back(&span);
      }
    }
    for (SolidSpan* span : low) span->is_floor = true;
  }

  bool has_floor_beside(const Spot& spot, float height_m) const {
    for (std::size_t side = 0; side < kSides; ++side) {
      const Spot beside = spot + Spot(kAround[side][0], kAround[side][1]);
      if (!columns_.grid.contains(beside)) continue;
      for (const SolidSpan& span : columns_.of(columns_.grid.index(beside))) {
        if (span.is_floor && std::abs(span.top_m - height_m) <= agent_.climb_m) return true;
      }
    }
    return false;
  }

  // Floor with room above.
  void mark_headroom() {
    for (std::size_t column = 0; column < columns_.grid.count(); ++column) {
      const std::span<SolidSpan> spans = columns_.of(column);
      for (std::size_t i = 0; i < spans.size(); ++i) {
        const bool has_room = i + 1 == spans.size() || spans[i + 1].low_m - spans[i].top_m >= agent_.height_m;
        spans[i].is_walkable = spans[i].is_floor && has_room;
      }
    }
  }

  // The walkable span in a spot to which a step leads from this height; nullptr if there is none.
  SolidSpan* step_to(const Spot& spot, float height_m) const {
    if (!columns_.grid.contains(spot)) return nullptr;
    for (SolidSpan& span : columns_.of(columns_.grid.index(spot))) {
      if (span.is_walkable && std::abs(span.top_m - height_m) <= agent_.climb_m) return &span;
    }
    return nullptr;
  }

  // Takes out where the agent's rim would leave what is walkable.
  void erode() {
    std::vector<std::uint8_t> too_near(columns_.spans.size(), 0);
    std::vector<int> done(columns_.grid.count(), kNoLevel);
    for (std::size_t column = 0; column < columns_.grid.count(); ++column) {
      for (const SolidSpan& span : columns_.of(column)) {
        if (span.is_walkable) mark_too_near(columns_.grid.at(column), span.top_m, done, too_near);
      }
    }
    for (std::size_t i = 0; i < too_near.size(); ++i) {
      if (too_near[i] != 0) columns_.spans[i].is_walkable = false;
    }
  }

  // Numbers what hangs together.
  void number_islands() {
    std::int32_t islands = 0;
    for (std::size_t column = 0; column < columns_.grid.count(); ++column) {
      for (SolidSpan& span : columns_.of(column)) {
        if (span.is_walkable && span.island == 0) flood(columns_.grid.at(column), span, ++islands);
      }
    }
  }

 private:
  static constexpr int kNoLevel = std::numeric_limits<int>::min();

  // If a neighbour of this walkable spot is none: the spans within the radius of that neighbour's centre. `done`: at which
  // height of a quarter of a metre each spot was such a neighbour before.
  void mark_too_near(const Spot& spot, float height_m, std::vector<int>& done, std::vector<std::uint8_t>& too_near) const {
    const int level = static_cast<int>(std::floor(height_m * 4));
    for (const auto& step : kAround) {
      const Spot blocked = spot + Spot(step[0], step[1]);
      if (step_to(blocked, height_m) != nullptr) continue;
      if (columns_.grid.contains(blocked) && std::exchange(done[columns_.grid.index(blocked)], level) == level) continue;
      mark_disc(blocked, height_m, too_near);
    }
  }

  void mark_disc(const Spot& middle, float height_m, std::vector<std::uint8_t>& too_near) const {
    const double radius = agent_.radius_m / columns_.grid.cell_m;
    const int reach = static_cast<int>(std::floor(radius));
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) {
        const Spot spot = middle + Spot(dx, dy);
        if (dx * dx + dy * dy >= radius * radius || !columns_.grid.contains(spot)) continue;
        const std::size_t column = columns_.grid.index(spot);
        for (std::uint32_t i = columns_.first[column]; i < columns_.first[column + 1]; ++i) {
          // An agent of this height that stands there would touch it.
          if (std::abs(columns_.spans[i].top_m - height_m) < agent_.height_m) too_near[i] = 1;
        }
      }
    }
  }

  void flood(const Spot& from, SolidSpan& seed, std::int32_t island) const {
    std::vector<std::pair<Spot, float>> waiting = {{from, seed.top_m}};
    seed.island = island;
    while (!waiting.empty()) {
      const auto [spot, height_m] = waiting.back();
      waiting.pop_back();
      for (std::size_t side = 0; side < kSides; ++side) {
        const Spot next = spot + Spot(kAround[side][0], kAround[side][1]);
        SolidSpan* span = step_to(next, height_m);
        if (span == nullptr || span->island != 0) continue;
        span->island = island;
        waiting.emplace_back(next, span->top_m);
      }
    }
  }

  SolidColumns& columns_;
  const AgentSize& agent_;
};

}  // namespace

void mark_walkable(SolidColumns& columns, const AgentSize& agent) {
  Walkable walkable(columns, agent);
  walkable.add_low_steps();
  walkable.mark_headroom();
  walkable.erode();
  walkable.number_islands();
}

}  // namespace panoptic
