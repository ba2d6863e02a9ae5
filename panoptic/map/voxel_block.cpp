// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/voxel_block.h"

#include <cstring>
#include <utility>

#include "panoptic/map/brick_pool.h"

namespace panoptic {
namespace {

constexpr FloatPlane kFloats[] = {FloatPlane::kDistance, FloatPlane::kWeight, FloatPlane::kLabelWeight, FloatPlane::kVoteSum};
constexpr WordPlane kWords[] = {WordPlane::kLabel, WordPlane::kRed, WordPlane::kGreen, WordPlane::kBlue};

template <typename Planes>
auto& plane_of(Planes& planes, FloatPlane p) {
  switch (p) {
    case FloatPlane::kDistance:
      return planes.distance;
    case FloatPlane::kWeight:
      return planes.weight;
    case FloatPlane::kLabelWeight:
      return planes.label_weight;
    default:
      return planes.vote_sum;
  }
}

template <typename Planes>
auto& plane_of(Planes& planes, WordPlane p) {
  switch (p) {
    case WordPlane::kLabel:
      return planes.label;
    case WordPlane::kRed:
      return planes.red;
    case WordPlane::kGreen:
      return planes.green;
    default:
      return planes.blue;
  }
}

// Calls visit(plane) for each plane of both kinds.
template <typename Visit>
void for_each_plane(const Visit& visit) {
  for (const FloatPlane p : kFloats) visit(p);
  for (const WordPlane p : kWords) visit(p);
}

// A bit for every voxel of the brick that holds anything in `planes`.
std::uint64_t held(const BlockPlanes& planes, int brick) {
  std::uint64_t all = 0;
  for (int v = 0; v < kBrickVoxels; ++v) {
    const auto i = static_cast<std::size_t>(offset_in_block(brick, v));
    const auto bits = [i](const auto& plane) { return std::bit_cast<std::uint32_t>(plane[i]); };
    const std::uint32_t floats = bits(planes.distance) | bits(planes.weight) | bits(planes.label_weight) | bits(planes.vote_sum);
    const bool any = (floats | planes.label[i] | planes.red[i] | planes.green[i] | planes.blue[i]) != 0;
    all |= std::uint64_t{any} << v;
  }
  return all;
}

// Copies the planes of a brick to one that stores more voxels, which may lie in the same memory if it has the same capacity: from
// the last voxel to the first, none moves towards the front.
void spread_planes(const Brick& before, Brick& after) {
  std::array<int, kBrickVoxels> places{};  // for each new voxel: how many of the old ones come before it
  int added = 0;
  for (std::uint64_t rest = after.stored() & ~before.stored(); rest != 0; rest &= rest - 1) {
    places[static_cast<std::size_t>(added++)] = before.place(std::countr_zero(rest));
  }
  for_each_plane([&](auto p) {
    const auto* from = before.plane(p);
    auto* to = after.plane(p);
    int end = before.count();
    for (int n = added; n > 0; --n) {
      const int place = places[static_cast<std::size_t>(n - 1)];
      std::memmove(to + place + n, from + place, static_cast<std::size_t>(end - place) * sizeof *to);
      to[place + n - 1] = 0;
      end = place;
    }
    if (from != to) std::memcpy(to, from, static_cast<std::size_t>(end) * sizeof *to);
  });
}

}  // namespace

Voxel VoxelBlock::at(int offset) const {
  const Brick& b = brick(brick_of(offset));
  const int voxel = voxel_in_brick(offset);
  if ((b.stored() >> voxel & 1) == 0) return {};
  const int i = b.place(voxel);
  return {b.plane(FloatPlane::kDistance)[i], b.plane(FloatPlane::kWeight)[i], b.plane(FloatPlane::kLabelWeight)[i],
          b.plane(FloatPlane::kVoteSum)[i],  b.plane(WordPlane::kLabel)[i],   b.plane(WordPlane::kRed)[i],
          b.plane(WordPlane::kGreen)[i],     b.plane(WordPlane::kBlue)[i]};
}

void VoxelBlock::set(int offset, const Voxel& voxel) {
  store(brick_of(offset), std::uint64_t{1} << voxel_in_brick(offset));
  Brick& b = brick(brick_of(offset));
  const int i = b.place(voxel_in_brick(offset));
  b.plane(FloatPlane::kDistance)[i] = voxel.distance;
  b.plane(FloatPlane::kWeight)[i] = voxel.weight;
  b.plane(FloatPlane::kLabelWeight)[i] = voxel.label_weight;
  b.plane(FloatPlane::kVoteSum)[i] = voxel.vote_sum;
  b.plane(WordPlane::kLabel)[i] = voxel.label;
  b.plane(WordPlane::kRed)[i] = voxel.red;
  b.plane(WordPlane::kGreen)[i] = voxel.green;
  b.plane(WordPlane::kBlue)[i] = voxel.blue;
}

void VoxelBlock::set_label(int offset, std::uint16_t label) {
  store(brick_of(offset), std::uint64_t{1} << voxel_in_brick(offset));
  Brick& b = brick(brick_of(offset));
  b.plane(WordPlane::kLabel)[b.place(voxel_in_brick(offset))] = label;
}

void VoxelBlock::set_label_weight(int offset, float weight) {
  store(brick_of(offset), std::uint64_t{1} << voxel_in_brick(offset));
  Brick& b = brick(brick_of(offset));
  b.plane(FloatPlane::kLabelWeight)[b.place(voxel_in_brick(offset))] = weight;
}

bool VoxelBlock::rename_labels(std::span<const std::uint16_t> new_label) {
  bool changed = false;
  for (Brick& b : bricks_) {
    std::uint16_t* labels = b.plane(WordPlane::kLabel);
    int stays = -1;  // the last label that keeps its name: labels come in long runs
    for (int i = 0; i < b.count(); ++i) {
      if (labels[i] == stays) continue;
      const std::uint16_t renamed = new_label[labels[i]];
      if (renamed == labels[i]) {
        stays = renamed;
      } else {
        labels[i] = renamed;
        changed = true;
      }
    }
  }
  return changed;
}

void VoxelBlock::store(int brick, std::uint64_t voxels) {
  Brick& kept = bricks_[static_cast<std::size_t>(brick)];
  const Brick before = kept;
  Brick after(before.stored() | voxels, before.planes());
  if (after.stored() == before.stored()) return;
  if (after.capacity() != before.capacity()) after = Brick(after.stored(), pool_->allocate(after.capacity()));
  kept = after;
  if (before.stored() == 0) return;
  spread_planes(before, after);
  if (after.planes() != before.planes()) pool_->give_back(before.planes(), before.capacity());
}

void VoxelBlock::forget(int brick, std::uint64_t voxels) {
  Brick& kept = bricks_[static_cast<std::size_t>(brick)];
  const Brick before = kept;
  const std::uint64_t stays = before.stored() & ~voxels;
  if (stays == before.stored()) return;
  Brick after;
  if (stays != 0) after = Brick(stays, pool_->allocate(Brick(stays, nullptr).capacity()));
  int to = 0;
  for (std::uint64_t rest = stays; rest != 0; rest &= rest - 1, ++to) {
    const int from = before.place(std::countr_zero(rest));
    for_each_plane([&](auto p) { after.plane(p)[to] = before.plane(p)[from]; });
  }
  kept = after;
  pool_->give_back(before.planes(), before.capacity());
}

void VoxelBlock::clear() {
  for (Brick& b : bricks_) {
    if (b.stored() != 0) pool_->give_back(b.planes(), b.capacity());
    b = Brick();
  }
}

void VoxelBlock::pack(const BlockPlanes& planes) {
  clear();
  for (int n = 0; n < kBlockBricks; ++n) {
    store(n, held(planes, n));
    Brick& b = brick(n);
    int i = 0;
    for (std::uint64_t rest = b.stored(); rest != 0; rest &= rest - 1, ++i) {
      const auto offset = static_cast<std::size_t>(offset_in_block(n, std::countr_zero(rest)));
      for_each_plane([&](auto p) { b.plane(p)[i] = plane_of(planes, p)[offset]; });
    }
  }
}

void VoxelBlock::copy(const VoxelBlock& other) {
  clear();
  for (int n = 0; n < kBlockBricks; ++n) {
    const Brick& from = other.brick(n);
    store(n, from.stored());
    if (from.stored() == 0) continue;
    std::memcpy(brick(n).planes(), from.planes(), static_cast<std::size_t>(from.capacity()) * kVoxelBytes);
  }
}

void VoxelBlock::unpack(BlockPlanes& planes) const {
  std::memset(static_cast<void*>(&planes), 0, sizeof planes);
  for (int n = 0; n < kBlockBricks; ++n) {
    const Brick& b = brick(n);
    int i = 0;
    for (std::uint64_t rest = b.stored(); rest != 0; rest &= rest - 1, ++i) {
      const auto offset = static_cast<std::size_t>(offset_in_block(n, std::countr_zero(rest)));
      for_each_plane([&](auto p) { plane_of(planes, p)[offset] = b.plane(p)[i]; });
    }
  }
}

}  // namespace panoptic
