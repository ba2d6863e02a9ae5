// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/surface_samples.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <string_view>
#include <utility>

#include "panoptic/map/voxel_grid.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr int kSide = kBlockSide + 2;  // the block's voxels and one more on each side
constexpr float kUnseen = std::numeric_limits<float>::quiet_NaN();
constexpr std::array<int, 3> kStep = {1, kSide, kSide* kSide};

constexpr int padded(int x, int y, int z) { return (x + 1) + kSide * ((y + 1) + kSide * (z + 1)); }

// The distances in a block and at the faces of its neighbours; NaN where nothing was observed.
class Distances {
 public:
  Distances(const VoxelMap& map, BlockIndex index) {
    values_.fill(kUnseen);
    const VoxelBlock& own = *map.find(index);
    for (int n = 0; n < kBlockBricks; ++n) add_brick(own.brick(n), n);
    for (int axis = 0; axis < 3; ++axis) {
      for (const int side : {-1, 1}) add_face(map, index, axis, side);
    }
  }

  float operator[](int place) const { return values_[static_cast<std::size_t>(place)]; }

  // The slope along an axis, per voxel; 0 where it is not known.
  float slope(int place, int axis) const {
    const int step = kStep[static_cast<std::size_t>(axis)];
    const float here = (*this)[place];
    const float before = (*this)[place - step];
    const float after = (*this)[place + step];
    if (std::isnan(before)) return std::isnan(after) ? 0.0F : after - here;
    return std::isnan(after) ? here - before : (after - before) / 2;
  }

 private:
  static bool counts(float weight) { return weight > MesherOptions{}.min_weight; }

  void add_brick(const Brick& brick, int number) {
    const float* distance = brick.plane(FloatPlane::kDistance);
    const float* weight = brick.plane(FloatPlane::kWeight);
    int i = 0;
    for (std::uint64_t rest = brick.stored(); rest != 0; rest &= rest - 1, ++i) {
      const int offset = offset_in_block(number, std::countr_zero(rest));
      if (!counts(weight[i])) continue;
      const int place = padded(offset % kBlockSide, offset / kBlockSide % kBlockSide, offset / (kBlockSide * kBlockSide));
      values_[static_cast<std::size_t>(place)] = distance[i];
    }
  }

  void add_face(const VoxelMap& map, BlockIndex index, int axis, int side) {
    const std::array<int, 3> step = {axis == 0 ? side : 0, axis == 1 ? side : 0, axis == 2 ? side : 0};
    const VoxelBlock* block = map.find({index.x + step[0], index.y + step[1], index.z + step[2]});
    if (block == nullptr) return;
    for (int a = 0; a < kBlockSide; ++a) {
      for (int b = 0; b < kBlockSide; ++b) {
        std::array<int, 3> at{};
        at[static_cast<std::size_t>(axis)] = side < 0 ? kBlockSide - 1 : 0;
        at[static_cast<std::size_t>((axis + 1) % 3)] = a;
        at[static_cast<std::size_t>((axis + 2) % 3)] = b;
        const int offset = voxel_offset(at[0], at[1], at[2]);
        if (!counts(block->weight(offset))) continue;
        at[static_cast<std::size_t>(axis)] = side < 0 ? -1 : kBlockSide;
        values_[static_cast<std::size_t>(padded(at[0], at[1], at[2]))] = block->distance(offset);
      }
    }
  }

  std::array<float, kSide * kSide * kSide> values_{};
};

// Makes the samples of one block.
class BlockSampler {
 public:
  BlockSampler(const VoxelMap& map, Slot slot)
      : map_(map), index_(map.index_of(slot)), block_(map.block(slot)), distances_(map, index_) {}

  std::vector<SurfaceSample> take() {
    for (int offset = 0; offset < kBlockVoxels; ++offset) {
      const VoxelIndex at = voxel_at({0, 0, 0}, offset);
      if (std::isnan(distances_[place_of_voxel(at)])) continue;
      for (std::size_t axis = 0; axis < 3; ++axis) add_edge(offset, at, axis);
    }
    return std::move(samples_);
  }

 private:
  static int place_of_voxel(const VoxelIndex& at) { return padded(at[0], at[1], at[2]); }

  void add_edge(int offset, const VoxelIndex& at, std::size_t axis) {
    VoxelIndex next = at;
    ++next[axis];
    const int place = place_of_voxel(at);
    const int next_place = place_of_voxel(next);
    const float here = distances_[place];
    const float there = distances_[next_place];
    if (std::isnan(there) || (here < 0) == (there < 0)) return;
    const float along = here / (here - there);
    const bool is_here = along < 0.5F;
    const VoxelIndex first = first_voxel(index_);
    Vec3d middle = center_m({first[0] + at[0], first[1] + at[1], first[2] + at[2]}, map_.voxel_size_m());
    middle[static_cast<Eigen::Index>(axis)] += double{along} * map_.voxel_size_m();
    // A voxel of another block has no neighbours here to take a slope from.
    const Vec3f normal = normal_at(is_here || next[axis] == kBlockSide ? place : next_place);
    const auto [other, there_offset] = voxel_of(next);
    samples_.push_back({middle.cast<float>(), normal, LabelSlot{is_here ? block_.label(offset) : other.label(there_offset)},
                        std::min(block_.weight(offset), other.weight(there_offset))});
  }

  // The block and the offset in it of a voxel that may lie in the next block.
  std::pair<const VoxelBlock&, int> voxel_of(const VoxelIndex& at) const {
    const VoxelIndex first = first_voxel(index_);
    const VoxelPlace voxel = place_of({first[0] + at[0], first[1] + at[1], first[2] + at[2]});
    return {voxel.block == index_ ? block_ : *map_.find(voxel.block), voxel.offset};
  }

  Vec3f normal_at(int place) const {
    const Vec3f slope(distances_.slope(place, 0), distances_.slope(place, 1), distances_.slope(place, 2));
    const float length = slope.norm();
    return length > 0 ? Vec3f(slope / length) : Vec3f(Vec3f::Zero());
  }

  const VoxelMap& map_;
  BlockIndex index_;
  const VoxelBlock& block_;
  Distances distances_;
  std::vector<SurfaceSample> samples_;
};

}  // namespace

std::vector<SurfaceSample> surface_samples(const VoxelMap& map, Slot slot) {
  return std::make_unique<BlockSampler>(map, slot)->take();
}

SurfaceByBlock surface_samples(const VoxelMap& map) {
  SurfaceByBlock points(map.block_count());
  parallel_for(points.size(), [&](std::size_t slot) { points[slot] = surface_samples(map, static_cast<Slot>(slot)); });
  return points;
}

bool is_floor_class(const LabelSet& labels, ClassId id) {
  constexpr std::array<std::string_view, 6> kNames = {"floor", "floor mat", "floormat", "rug", "carpet", "stairs"};
  const LabelClass* of = labels.find(id);
  return of != nullptr && std::find(kNames.begin(), kNames.end(), of->name) != kNames.end();
}

}  // namespace panoptic
