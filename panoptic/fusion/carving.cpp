// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/carving.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "panoptic/base/clones.h"
#include "panoptic/fusion/flags.h"
#include "panoptic/fusion/project_brick.h"

namespace panoptic {
namespace {

// The baseline of two views that count as two, as a share of the distance.
constexpr double kParallax = 0.05;

}  // namespace

namespace kernels {

// The voxels of a brick in the camera frame, each with the reading at its pixel.
struct BrickInView {
  alignas(64) float x[kBrickVoxels];
  alignas(64) float y[kBrickVoxels];
  alignas(64) float z[kBrickVoxels];
  alignas(64) float inverse_z[kBrickVoxels];
  alignas(64) std::int32_t pixel[kBrickVoxels];
  alignas(64) float depth[kBrickVoxels];
};

void view_brick(const KernelFrame& frame, const BlockInCamera& place, int brick, BrickInView& out);
std::uint64_t readings_behind(const BrickInView& brick, float clearance_m);

PANOPTIC_CLONES
void view_brick(const KernelFrame& frame_in, const BlockInCamera& place_in, int brick, BrickInView& out) {
  const KernelFrame frame = frame_in;
  const BlockInCamera place = place_in;
  BrickInView* __restrict seen = &out;
  project_brick(frame, place, brick, 0, *seen);
  for (int k = 0; k < kBrickVoxels; ++k) seen->depth[k] = frame.depth[seen->pixel[k]];
}

// Voxels whose own pixel sees something farther behind: no others are looked through.
PANOPTIC_CLONES
std::uint64_t readings_behind(const BrickInView& brick, float clearance_m) {
  alignas(64) std::uint8_t behind[kBrickVoxels];
  for (int k = 0; k < kBrickVoxels; ++k) behind[k] = brick.depth[k] - brick.z[k] > clearance_m ? 1 : 0;
  return bits_of(behind);
}

}  // namespace kernels

namespace {

float clearance_m(const VoxelMap& map) { return kClearance_voxels * map.voxel_size_m(); }

// How far around a voxel at this distance from the surface there must be nothing, if there is to be none where it says.
float around_m(float distance_m, const VoxelMap& map) { return std::max(clearance_m(map), distance_m + map.voxel_size_m()); }

bool sees_through(const SightOfBlock& sight, const Vec3f& point, float around_m) {
  const KernelFrame& frame = sight.view.pixels;
  if (!(point.z() - around_m > 1e-3F)) return false;
  const PixelBounds range = pixels_around(frame, point, around_m);
  const bool whole = range.first_u >= 0 && range.first_v >= 0 && range.last_u <= static_cast<float>(frame.width - 1) &&
                     range.last_v <= static_cast<float>(frame.height - 1);
  if (!whole) return false;
  const PixelArea pixels{static_cast<std::int32_t>(range.first_u), static_cast<std::int32_t>(range.last_u),
                         static_cast<std::int32_t>(range.first_v), static_cast<std::int32_t>(range.last_v)};
  return sight.tiles.certain_m(pixels) > point.z() + around_m + depth_error_m(point.z());
}

// The stored voxels that the view looks through.
std::uint64_t looked_through(const SightOfBlock& sight, const Brick& brick, const kernels::BrickInView& seen) {
  std::uint64_t through = 0;
  for (std::uint64_t left = brick.stored() & kernels::readings_behind(seen, clearance_m(sight.map.voxels)); left != 0;
       left &= left - 1) {
    const int v = std::countr_zero(left);
    const int k = brick.place(v);
    if (!(brick.plane(FloatPlane::kWeight)[k] > 0)) continue;
    const float around = around_m(std::abs(brick.plane(FloatPlane::kDistance)[k]), sight.map.voxels);
    // Its own pixel first: the others take longer.
    if (!(seen.depth[v] > seen.z[v] + around + depth_error_m(seen.z[v]))) continue;
    through |= std::uint64_t{sees_through(sight, {seen.x[v], seen.y[v], seen.z[v]}, around)} << v;
  }
  return through;
}

// The stored voxels that are right about the surface: their own pixel sees one where they say.
std::uint64_t confirmed(const SightOfBlock& sight, const Brick& brick, const kernels::BrickInView& seen) {
  std::uint64_t hit = 0;
  for (std::uint64_t left = brick.stored(); left != 0; left &= left - 1) {
    const int v = std::countr_zero(left);
    const float distance = std::abs(brick.plane(FloatPlane::kDistance)[brick.place(v)]);
    const float reach = around_m(distance, sight.map.voxels) + depth_error_m(seen.z[v]);
    const bool is_right = seen.depth[v] > 0 && std::abs(seen.depth[v] - seen.z[v]) < reach;
    hit |= std::uint64_t{is_right} << v;
  }
  return hit;
}

// Adds one to the counts of the voxels.
void count_up(Doubt& doubt, std::uint64_t voxels) {
  for (std::uint64_t& plane : doubt.count) {
    const std::uint64_t carry = plane & voxels;
    plane ^= voxels;
    voxels = carry;
  }
}

// The voxels that were counted so often.
std::uint64_t counted(const Doubt& doubt, int views) {
  std::uint64_t all = ~std::uint64_t{0};
  for (std::size_t n = 0; n < doubt.count.size(); ++n) all &= (views >> n & 1) != 0 ? doubt.count[n] : ~doubt.count[n];
  return all;
}

void forget(Doubt& doubt, std::uint64_t voxels) {
  for (std::uint64_t& plane : doubt.count) plane &= ~voxels;
}

bool is_empty(const Doubt& doubt) { return (doubt.count[0] | doubt.count[1] | doubt.count[2]) == 0; }

// The voxels of the sight that are to be cleared.
std::uint64_t take_down(const BrickSight& sight, const Vec3d& camera_m, int views, FreeSpaceMap& space) {
  const CellIndex cell = cell_of(sight.block, sight.brick);
  const Doubt* before = space.doubt(cell);
  if (before == nullptr && sight.through == 0) return 0;
  Doubt doubt = before == nullptr ? Doubt{} : *before;
  forget(doubt, sight.hit);
  const Vec3d middle_m = (Vec3d(cell[0], cell[1], cell[2]) + Vec3d::Constant(0.5)) * double{space.cell_size_m()};
  const double baseline_m = (camera_m - doubt.seen_from_m.cast<double>()).norm();
  const bool counts = before == nullptr || baseline_m > kParallax * (camera_m - middle_m).norm();
  std::uint64_t carved = 0;
  if (counts && sight.through != 0) {
    count_up(doubt, sight.through);
    doubt.seen_from_m = camera_m.cast<float>();
    carved = counted(doubt, views);
    forget(doubt, carved);
  }
  if (is_empty(doubt)) {
    space.drop_doubt(cell);
  } else if (before == nullptr || doubt != *before) {
    space.set_doubt(cell, doubt);
  }
  return carved;
}

}  // namespace

void SightOfBlock::look(Slot slot, std::uint64_t bricks, std::vector<BrickSight>& sights) const {
  const BlockIndex index = map.voxels.index_of(slot);
  const VoxelBlock& block = map.voxels.block(slot);
  const BlockInCamera place = view.in_camera(index, map.voxels.voxel_size_m());
  const std::uint64_t doubted = map.free_space.doubted(index);
  for (std::uint64_t rest = bricks; rest != 0; rest &= rest - 1) {
    const int number = std::countr_zero(rest);
    const Brick& brick = block.brick(number);
    if (brick.stored() == 0) continue;
    kernels::BrickInView seen;  // NOLINT(cppcoreguidelines-pro-type-member-init): filled by view_brick
    kernels::view_brick(view.pixels, place, number, seen);
    BrickSight sight{slot, index, number, looked_through(*this, brick, seen), 0};
    if ((doubted >> number & 1) != 0) sight.hit = confirmed(*this, brick, seen);
    if ((sight.through | sight.hit) != 0) sights.push_back(sight);
  }
}

std::vector<CarvedVoxels> carve(const std::vector<BrickSight>& sights, const Vec3d& camera_m, int views, FreeSpaceMap& space) {
  std::vector<CarvedVoxels> carved;
  for (const BrickSight& sight : sights) {
    const std::uint64_t voxels = take_down(sight, camera_m, views, space);
    if (voxels != 0) carved.push_back({sight.slot, sight.brick, voxels});
  }
  return carved;
}

void clear(std::span<const CarvedVoxels> carved, VoxelMap& map) {
  for (const CarvedVoxels& c : carved) {
    map.block(c.slot).forget(c.brick, c.voxels);
    map.mark_changed(c.slot);
  }
}

}  // namespace panoptic
