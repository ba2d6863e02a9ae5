// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/surface_samples.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
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

enum class Faces { kNext, kAll };

// The distances in a block and at the faces of its neighbours, or of the next ones alone; NaN where nothing was observed.
class Distances {
 public:
  Distances(const VoxelMap& map, BlockIndex index, Faces faces) {
    values_.fill(kUnseen);
    const VoxelBlock& own = *map.find(index);
    for (int n = 0; n < kBlockBricks; ++n) add_brick(own.brick(n), n);
    for (int axis = 0; axis < 3; ++axis) {
      if (faces == Faces::kAll) add_face(map, index, axis, -1);
      add_face(map, index, axis, 1);
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

// Bit x stands for the voxel x of a row of the padded block, its padding left out.
struct RowBits {
  std::uint32_t seen = 0;    // bit 16: the next block's first voxel
  std::uint32_t behind = 0;  // the distance is negative
};

RowBits row_bits(const Distances& distances, int y, int z) {
  RowBits bits;
  for (int x = 0; x <= kBlockSide; ++x) {
    const float value = distances[padded(x, y, z)];
    bits.seen |= (std::isnan(value) ? 0U : 1U) << x;
    bits.behind |= (value < 0 ? 1U : 0U) << x;
  }
  return bits;
}

// Where the sign changes between the voxels of two rows, one beside the other.
std::uint32_t sign_changes(const RowBits& a, const RowBits& b) { return a.seen & b.seen & (a.behind ^ b.behind); }

using BlockBits = std::array<std::array<RowBits, kBlockSide + 1>, kBlockSide + 1>;  // [z][y]

BlockBits block_bits(const Distances& distances) {
  BlockBits bits;
  for (std::size_t z = 0; z < bits.size(); ++z) {
    for (std::size_t y = 0; y < bits.size(); ++y) bits[z][y] = row_bits(distances, static_cast<int>(y), static_cast<int>(z));
  }
  return bits;
}

// Calls visit(voxel, axis) for the voxels of a row of the block that have their bit in the mask of the axis.
template <typename Visit>
void visit_row(const std::array<std::uint32_t, 3>& edges, int y, int z, const Visit& visit) {
  constexpr std::uint32_t kOwn = (1U << kBlockSide) - 1;
  for (std::uint32_t rest = (edges[0] | edges[1] | edges[2]) & kOwn; rest != 0; rest &= rest - 1) {
    const int x = std::countr_zero(rest);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if ((edges[axis] >> x & 1U) != 0) visit(VoxelIndex{x, y, z}, axis);
    }
  }
}

// Calls visit(voxel of the block, axis) for every voxel whose sign differs from the next one's along the axis.
template <typename Visit>
void visit_edges(const Distances& distances, const Visit& visit) {
  const BlockBits bits = block_bits(distances);
  for (std::size_t z = 0; z < kBlockSide; ++z) {
    for (std::size_t y = 0; y < kBlockSide; ++y) {
      const RowBits& own = bits[z][y];
      const std::array<std::uint32_t, 3> edges = {sign_changes(own, {own.seen >> 1, own.behind >> 1}),
                                                  sign_changes(own, bits[z][y + 1]), sign_changes(own, bits[z + 1][y])};
      visit_row(edges, static_cast<int>(y), static_cast<int>(z), visit);
    }
  }
}

int padded(const VoxelIndex& at) { return padded(at[0], at[1], at[2]); }

VoxelIndex next_along(VoxelIndex at, std::size_t axis) {
  ++at[axis];
  return at;
}

// Which part of the way to the next voxel the surface is away.
float share_of_edge(const Distances& distances, const VoxelIndex& at, std::size_t axis) {
  const float here = distances[padded(at)];
  return here / (here - distances[padded(next_along(at, axis))]);
}

Vec3f on_edge(const VoxelIndex& first, const VoxelIndex& at, std::size_t axis, float share, float voxel_size_m) {
  Vec3d middle = center_m({first[0] + at[0], first[1] + at[1], first[2] + at[2]}, voxel_size_m);
  middle[static_cast<Eigen::Index>(axis)] += double{share} * voxel_size_m;
  return middle.cast<float>();
}

// Makes the samples of one block.
class BlockSampler {
 public:
  BlockSampler(const VoxelMap& map, Slot slot)
      : map_(map), index_(map.index_of(slot)), block_(map.block(slot)), distances_(map, index_, Faces::kAll) {}

  std::vector<SurfaceSample> take() {
    visit_edges(distances_, [&](const VoxelIndex& at, std::size_t axis) { add_edge(at, axis); });
    return std::move(samples_);
  }

 private:
  void add_edge(const VoxelIndex& at, std::size_t axis) {
    const VoxelIndex next = next_along(at, axis);
    const float share = share_of_edge(distances_, at, axis);
    const bool is_here = share < 0.5F;
    // A voxel of another block has no neighbours here to take a slope from.
    const Vec3f normal = normal_at(padded(is_here || next[axis] == kBlockSide ? at : next));
    const int offset = voxel_offset(at[0], at[1], at[2]);
    const auto [other, there_offset] = voxel_of(next);
    samples_.push_back({on_edge(first_voxel(index_), at, axis, share, map_.voxel_size_m()), normal,
                        LabelSlot{is_here ? block_.label(offset) : other.label(there_offset)},
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

std::vector<Vec3f> surface_places(const VoxelMap& map, Slot slot) {
  const auto distances = std::make_unique<Distances>(map, map.index_of(slot), Faces::kNext);
  const VoxelIndex first = first_voxel(map.index_of(slot));
  std::vector<Vec3f> places;
  visit_edges(*distances, [&](const VoxelIndex& at, std::size_t axis) {
    places.push_back(on_edge(first, at, axis, share_of_edge(*distances, at, axis), map.voxel_size_m()));
  });
  return places;
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
