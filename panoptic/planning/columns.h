// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The surface of a map in columns of the z-up frame: where something solid is above each spot of the ground, and where one can
// stand on it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "panoptic/map.h"
#include "panoptic/planning.h"
#include "panoptic/planning/surface_samples.h"

namespace panoptic {

// Square spots low to low + size - 1 along x and y; x runs fastest.
struct GroundGrid {
  double cell_m = 0;
  Eigen::Vector2i low = Eigen::Vector2i::Zero();
  Eigen::Vector2i size = Eigen::Vector2i::Zero();

  std::size_t count() const { return static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y()); }
  bool contains(const Eigen::Vector2i& at) const {
    return ((at - low).array() >= 0).all() && ((at - low).array() < size.array()).all();
  }
  std::size_t index(const Eigen::Vector2i& at) const {
    return static_cast<std::size_t>(at.x() - low.x()) +
           static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(at.y() - low.y());
  }
  Eigen::Vector2i at(std::size_t index) const {
    const auto width = static_cast<std::size_t>(size.x());
    return low + Eigen::Vector2i(static_cast<int>(index % width), static_cast<int>(index / width));
  }
  Eigen::Vector2i around(const Eigen::Vector2d& p) const { return (p / cell_m).array().floor().matrix().cast<int>(); }
  Eigen::Vector2d center_m(const Eigen::Vector2i& at) const {
    return (at.cast<double>() + Eigen::Vector2d::Constant(0.5)) * cell_m;
  }
};

// Something solid in a column, from its lowest to its highest surface. `island` numbers the places that are reached from one
// another, from 1; 0: nobody can be there.
struct SolidSpan {
  float low_m = 0;
  float top_m = 0;
  // Its top is floor: level surface of a floor class, or no higher or lower than a step from the floor of the frame.
  bool is_floor = false;
  bool is_walkable = false;  // the agent's centre may stand on it
  std::int32_t island = 0;
};

struct SolidColumns {
  GroundGrid grid;
  std::vector<std::uint32_t> first;  // by column, and one past the end
  std::vector<SolidSpan> spans;      // of each column, from below

  std::span<SolidSpan> of(std::size_t column) { return {spans.data() + first[column], spans.data() + first[column + 1]}; }
  std::span<const SolidSpan> of(std::size_t column) const {
    return {spans.data() + first[column], spans.data() + first[column + 1]};
  }
};

// A sample of the surface in the frame of columns.
struct GroundSample {
  Vec3f at_m = Vec3f::Zero();
  bool is_floor = false;  // as SolidSpan says
  bool faces_down = false;
  LabelSlot label = LabelSlot::kUnknown;
  float weight = 0;  // of SurfaceSample
};

// Columns of samples that each stand for a square of `sample_m`. Spans are apart where nothing is for more than two of them; the
// top of a span is floor if a sample of floor lies no lower than `climb_m` below it.
SolidColumns solid_columns(const std::vector<GroundSample>& samples, double cell_m, double sample_m, double climb_m);

// The samples of a map in its z-up frame, for an agent that climbs so far.
std::vector<GroundSample> ground_samples(const PanopticMap& map, const UpFrame& frame, const SurfaceByBlock& surface,
                                         double climb_m);

// Decides where the agent may stand: on floor, with room for its height above, and nothing but walkable floor within its
// radius that it reaches by steps of at most climb_m. Numbers the islands.
void mark_walkable(SolidColumns& columns, const AgentSize& agent);

}  // namespace panoptic
