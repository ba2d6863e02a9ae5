// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/distance_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <tuple>

#include "panoptic/error.h"
#include "panoptic/parallel.h"
#include "panoptic/planning/distance_cells.h"
#include "panoptic/planning/space_at.h"
#include "panoptic/planning/surface_samples.h"

namespace panoptic {
namespace {

using Cells = std::vector<Cell>;

struct LowerCell {
  bool operator()(const Cell& a, const Cell& b) const { return std::tie(a.z(), a.y(), a.x()) < std::tie(b.z(), b.y(), b.x()); }
};

// Blocks that changed after the epoch, and those before them, whose last voxels have edges into them; ascending.
std::vector<Slot> blocks_to_read(const VoxelMap& map, std::uint64_t epoch) {
  std::set<Slot> slots;
  for (const Slot slot : map.changed_since(epoch)) {
    const BlockIndex at = map.index_of(slot);
    slots.insert(slot);
    for (const BlockIndex before :
         {BlockIndex{at.x - 1, at.y, at.z}, BlockIndex{at.x, at.y - 1, at.z}, BlockIndex{at.x, at.y, at.z - 1}}) {
      if (const Slot lower = map.find_slot(before); lower != VoxelMap::kNoSlot) slots.insert(lower);
    }
  }
  return {slots.begin(), slots.end()};
}

CellBox box_around(const std::vector<Cells>& cells) {
  Cell low = Cell::Constant(std::numeric_limits<int>::max());
  Cell high = Cell::Constant(std::numeric_limits<int>::min());
  for (const Cells& some : cells) {
    for (const Cell& cell : some) {
      low = low.cwiseMin(cell);
      high = high.cwiseMax(cell);
    }
  }
  return (low.array() > high.array()).any() ? CellBox{} : CellBox{low, high - low + Cell::Ones()};
}

// The eight cells around a point, and how far it is from the first to the last along each axis.
struct Corners {
  std::array<double, 8> distance{};  // number 1 is one farther along x, 2 along y, 4 along z
  Vec3d along = Vec3d::Zero();
  bool known = true;
};

}  // namespace

struct DistanceField::State {
  State(const UpFrame& up, const DistanceFieldOptions& o)
      : grid_from_world(up.grid_from_world),
        world_from_grid(up.grid_from_world.inverse()),
        options(o),
        cells(static_cast<int>(std::ceil(o.cap_m / o.cell_m))) {}

  Cell cell_of(const Vec3d& p) const { return (p / options.cell_m).array().floor().matrix().cast<int>(); }
  bool may_hold(const Vec3d& p) const {
    return p.allFinite() && p.cwiseAbs().maxCoeff() / options.cell_m < std::numeric_limits<int>::max() / 2;
  }
  Vec3d center_m(const Cell& cell) const { return (cell.cast<double>() + Vec3d::Constant(0.5)) * options.cell_m; }
  Cells surface_cells(const VoxelMap& voxels, Slot slot) const;
  double value(const Cell& cell) const;
  Corners corners(const Vec3d& p) const;
  // A map that was fused anew from corrected poses may have fewer blocks.
  void forget_blocks_from(std::size_t slot);

  Pose grid_from_world;
  Pose world_from_grid;
  DistanceFieldOptions options;
  DistanceCells cells;
  std::vector<Cells> of_block;       // by slot: cells with its surface
  const PanopticMap* map = nullptr;  // of the last update
  std::uint64_t seen_epoch = 0;
};

Cells DistanceField::State::surface_cells(const VoxelMap& voxels, Slot slot) const {
  Cells found;
  for (const Vec3f& place : surface_places(voxels, slot)) {
    const Cell cell = cell_of(grid_from_world * place.cast<double>());
    if (found.empty() || found.back() != cell) found.push_back(cell);
  }
  std::sort(found.begin(), found.end(), LowerCell());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

// NaN where nothing is known.
double DistanceField::State::value(const Cell& cell) const {
  const bool in_box = cells.box().contains(cell);
  const std::uint16_t squared = in_box ? cells.squared(cell) : DistanceCells::kFar;
  if (squared == 0) return 0;
  const Space space = map == nullptr ? Space::kUnknown : space_at(*map, world_from_grid * center_m(cell));
  if (space == Space::kUnknown) return std::numeric_limits<double>::quiet_NaN();
  const double distance = squared == DistanceCells::kFar
                              ? options.cap_m
                              : std::min(options.cap_m, std::sqrt(static_cast<double>(squared)) * options.cell_m);
  return space == Space::kFree ? distance : -distance;
}

Corners DistanceField::State::corners(const Vec3d& p) const {
  Corners corners;
  const Vec3d place = p / options.cell_m - Vec3d::Constant(0.5);
  const Vec3d first = place.array().floor();
  corners.along = place - first;
  for (int n = 0; n < 8; ++n) {
    const Cell step(n & 1, n >> 1 & 1, n >> 2 & 1);
    const double distance = value(first.cast<int>() + step);
    corners.known = corners.known && !std::isnan(distance);
    corners.distance[static_cast<std::size_t>(n)] = distance;
  }
  return corners;
}

void DistanceField::State::forget_blocks_from(std::size_t slot) {
  for (; slot < of_block.size(); ++slot) {
    for (const Cell& cell : of_block[slot]) cells.remove(cell);
    of_block[slot].clear();
  }
}

DistanceField::DistanceField(const UpFrame& frame, const DistanceFieldOptions& o) {
  if (!(o.cell_m >= 0.01 && o.cell_m <= 1)) throw Error(fmt::format("cells of {} m: they take 0.01 to 1 m", o.cell_m));
  if (!(o.cap_m >= o.cell_m && o.cap_m <= DistanceCells::kMostReach * o.cell_m)) {
    throw Error(fmt::format("distances up to {} m: the cap takes 1 to {} cells", o.cap_m, DistanceCells::kMostReach));
  }
  state_ = std::make_unique<State>(frame, o);
}

DistanceField::DistanceField(DistanceField&&) noexcept = default;
DistanceField& DistanceField::operator=(DistanceField&&) noexcept = default;
DistanceField::~DistanceField() = default;

double DistanceField::cell_m() const { return state_->options.cell_m; }
double DistanceField::cap_m() const { return state_->options.cap_m; }
const Pose& DistanceField::grid_from_world() const { return state_->grid_from_world; }

void DistanceField::update(const PanopticMap& map) {
  State& s = *state_;
  const std::vector<Slot> slots = blocks_to_read(map.voxels, s.seen_epoch);
  std::vector<Cells> found(slots.size());
  parallel_for(slots.size(), [&](std::size_t i) { found[i] = s.surface_cells(map.voxels, slots[i]); });
  s.cells.cover(box_around(found));
  s.forget_blocks_from(map.voxels.block_count());
  s.of_block.resize(map.voxels.block_count());
  for (std::size_t i = 0; i < slots.size(); ++i) {
    Cells& before = s.of_block[slots[i]];
    if (before == found[i]) continue;
    for (const Cell& cell : found[i]) s.cells.add(cell);
    for (const Cell& cell : before) s.cells.remove(cell);
    before = std::move(found[i]);
  }
  s.cells.update();
  s.map = &map;
  s.seen_epoch = map.voxels.epoch() - 1;  // what is stamped with this epoch may change again
}

std::optional<double> DistanceField::distance_at(const Vec3d& point_m) const {
  if (!state_->may_hold(point_m)) return std::nullopt;
  const double distance = state_->value(state_->cell_of(point_m));
  return std::isnan(distance) ? std::nullopt : std::optional(distance);
}

std::optional<double> DistanceField::distance_m(const Vec3d& point_m) const {
  if (!state_->may_hold(point_m)) return std::nullopt;
  const Corners c = state_->corners(point_m);
  if (!c.known) return std::nullopt;
  double sum = 0;
  for (int n = 0; n < 8; ++n) {
    double weight = 1;
    for (int a = 0; a < 3; ++a) weight *= (n >> a & 1) != 0 ? c.along[a] : 1 - c.along[a];
    sum += weight * c.distance[static_cast<std::size_t>(n)];
  }
  return sum;
}

std::optional<Vec3d> DistanceField::gradient(const Vec3d& point_m) const {
  if (!state_->may_hold(point_m)) return std::nullopt;
  const Corners c = state_->corners(point_m);
  if (!c.known) return std::nullopt;
  Vec3d slope = Vec3d::Zero();
  for (int n = 0; n < 8; ++n) {
    for (int axis = 0; axis < 3; ++axis) {
      double weight = (n >> axis & 1) != 0 ? 1 : -1;
      for (int a = 0; a < 3; ++a) {
        if (a != axis) weight *= (n >> a & 1) != 0 ? c.along[a] : 1 - c.along[a];
      }
      slope[axis] += weight * c.distance[static_cast<std::size_t>(n)];
    }
  }
  constexpr double kFlat = 1e-9;
  return slope.norm() > kFlat ? std::optional(Vec3d(slope.normalized())) : std::nullopt;
}

DistanceField::Values DistanceField::values() const {
  const State& s = *state_;
  constexpr int kRim = 2;  // surfaces have something behind them
  CellBox box = box_around(s.of_block);
  if (box.count() > 0) box = {box.low - Cell::Constant(kRim), box.size + Cell::Constant(2 * kRim)};
  Values values{box.size, s.center_m(box.low), std::vector<float>(box.count())};
  parallel_for(static_cast<std::size_t>(box.size.z()), [&](std::size_t z) {
    for (int y = 0; y < box.size.y(); ++y) {
      for (int x = 0; x < box.size.x(); ++x) {
        const Cell cell = box.low + Cell(x, y, static_cast<int>(z));
        values.distance_m[box.index(cell)] = static_cast<float>(s.value(cell));
      }
    }
  });
  return values;
}

}  // namespace panoptic
