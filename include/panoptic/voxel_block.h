// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A block of 16^3 voxels. It holds what was observed alone: a bit tells of each voxel whether it is stored, and the stored ones
// lie packed, property by property, in bricks of 4^3. Voxels that are not stored read as zero. docs/decisions/0014 says why.
//
// Threads: blocks may be read, and different blocks written, from different threads.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace panoptic {

inline constexpr int kBlockSide = 16;
inline constexpr int kBlockVoxels = kBlockSide * kBlockSide * kBlockSide;

// Voxel (x, y, z) of a block, each 0 to 15, has this offset. Its centre lies at (16 * block + (x, y, z) + 0.5) * voxel size.
constexpr int voxel_offset(int x, int y, int z) { return x + kBlockSide * (y + kBlockSide * z); }

// All that is known of a voxel; all zero = nothing.
struct Voxel {
  float distance = 0;       // truncated signed distance, metres, positive in front of the surface
  float weight = 0;         // W^D, 0 = never observed
  float label_weight = 0;   // W^L
  float vote_sum = 0;       // W^V, the weight of all votes, whatever they were for; 0 = nobody ever voted
  std::uint16_t label = 0;  // LabelSlot, 0 = unknown
  std::uint16_t red = 0;    // 8.8 fixed point: the mean keeps moving after hundreds of frames
  std::uint16_t green = 0;
  std::uint16_t blue = 0;
};

// The share of the votes that is for the label: W^L / W^V of Eq. 18, from 0 to 1; 0 where nobody voted.
constexpr float label_share(float label_weight, float vote_sum) {
  if (!(vote_sum > 0)) return 0;
  return label_weight < vote_sum ? label_weight / vote_sum : 1.0F;
}

// The voxels of a block spread out: one plane per property, by offset.
struct alignas(64) BlockPlanes {
  std::array<float, kBlockVoxels> distance{};
  std::array<float, kBlockVoxels> weight{};
  std::array<float, kBlockVoxels> label_weight{};
  std::array<float, kBlockVoxels> vote_sum{};
  std::array<std::uint16_t, kBlockVoxels> label{};
  std::array<std::uint16_t, kBlockVoxels> red{};
  std::array<std::uint16_t, kBlockVoxels> green{};
  std::array<std::uint16_t, kBlockVoxels> blue{};
};

inline constexpr int kBrickSide = 4;
inline constexpr int kBrickVoxels = kBrickSide * kBrickSide * kBrickSide;
inline constexpr int kBlockBricks = kBlockVoxels / kBrickVoxels;
inline constexpr int kVoxelBytes = 24;

// Brick (x, y, z) of a block, each 0 to 3, is number x + 4 y + 16 z; likewise the voxels of a brick.
constexpr int brick_of(int offset) { return (offset >> 2 & 3) | (offset >> 6 & 3) << 2 | (offset >> 10 & 3) << 4; }
constexpr int voxel_in_brick(int offset) { return (offset & 3) | (offset >> 4 & 3) << 2 | (offset >> 8 & 3) << 4; }
constexpr int spread(int number) { return (number & 3) | (number >> 2 & 3) << 4 | (number >> 4) << 8; }
constexpr int offset_in_block(int brick, int voxel) { return kBrickSide * spread(brick) + spread(voxel); }

enum class FloatPlane : std::uint8_t { kDistance, kWeight, kLabelWeight, kVoteSum };
enum class WordPlane : std::uint8_t { kLabel, kRed, kGreen, kBlue };

// The stored voxels of a brick, in the order of their numbers. Each plane has room for capacity() voxels, 8 at a time so that
// loops over a plane vectorise; what follows the last voxel means nothing (and is no NaN or denormal, which would be slow).
class Brick {
 public:
  Brick() = default;  // stores nothing
  Brick(std::uint64_t stored, std::byte* planes) : stored_(stored), planes_(planes) {}

  std::uint64_t stored() const { return stored_; }  // a bit per voxel
  int count() const { return std::popcount(stored_); }
  int capacity() const { return (count() + 7) & ~7; }
  // The place of a stored voxel in each plane.
  int place(int voxel) const { return std::popcount(stored_ & ((std::uint64_t{1} << voxel) - 1)); }

  float* plane(FloatPlane p) { return reinterpret_cast<float*>(planes_ + begin(p)); }
  const float* plane(FloatPlane p) const { return reinterpret_cast<const float*>(planes_ + begin(p)); }
  std::uint16_t* plane(WordPlane p) { return reinterpret_cast<std::uint16_t*>(planes_ + begin(p)); }
  const std::uint16_t* plane(WordPlane p) const { return reinterpret_cast<const std::uint16_t*>(planes_ + begin(p)); }
  std::byte* planes() const { return planes_; }
  // The label of a voxel, stored or not; without a branch, because readers ask for the voxels of pixels, which nobody can guess.
  std::uint16_t label(int voxel) const {
    const auto all = static_cast<std::uint16_t>(-static_cast<int>(stored_ >> voxel & 1));
    return reinterpret_cast<const std::uint16_t*>(planes_)[place(voxel)] & all;  // the first plane
  }

 private:
  alignas(64) static inline std::byte nothing[kBrickVoxels];

  std::size_t begin(FloatPlane p) const { return static_cast<std::size_t>(capacity() * (8 + 4 * static_cast<int>(p))); }
  std::size_t begin(WordPlane p) const { return static_cast<std::size_t>(2 * capacity() * static_cast<int>(p)); }

  std::uint64_t stored_ = 0;
  std::byte* planes_ = nothing;
};

class BrickPool;

class VoxelBlock {
 public:
  // The pool, which must outlive the block, gives the memory for voxels.
  explicit VoxelBlock(BrickPool& pool) : pool_(&pool) {}
  VoxelBlock(const VoxelBlock&) = delete;
  VoxelBlock& operator=(const VoxelBlock&) = delete;
  ~VoxelBlock() = default;

  // A voxel or one property of it, by offset.
  Voxel at(int offset) const;
  float distance(int offset) const { return value(FloatPlane::kDistance, offset); }
  float weight(int offset) const { return value(FloatPlane::kWeight, offset); }
  float label_weight(int offset) const { return value(FloatPlane::kLabelWeight, offset); }
  float vote_sum(int offset) const { return value(FloatPlane::kVoteSum, offset); }
  std::uint16_t label(int offset) const { return brick(brick_of(offset)).label(voxel_in_brick(offset)); }

  // Sets a voxel, and stores it if it was not.
  void set(int offset, const Voxel& voxel);
  void set_label(int offset, std::uint16_t label);
  void set_label_weight(int offset, float weight);
  // Replaces each label by new_label[label]; says whether any changed. REQUIRES that label 0 stays.
  bool rename_labels(std::span<const std::uint16_t> new_label);

  const Brick& brick(int number) const { return bricks_[static_cast<std::size_t>(number)]; }
  Brick& brick(int number) { return bricks_[static_cast<std::size_t>(number)]; }
  // Stores these voxels of a brick as well, all zero. Pointers into the brick become invalid.
  void store(int brick, std::uint64_t voxels);
  // Stores these voxels of a brick no longer: nothing is known of them. Pointers into the brick become invalid.
  void forget(int brick, std::uint64_t voxels);

  // Replaces the voxels by those that hold anything in `planes`, or by those of another block.
  void pack(const BlockPlanes& planes);
  void copy(const VoxelBlock& other);
  void unpack(BlockPlanes& planes) const;

 private:
  float value(FloatPlane p, int offset) const {
    const Brick& b = brick(brick_of(offset));
    const int voxel = voxel_in_brick(offset);
    return (b.stored() >> voxel & 1) != 0 ? b.plane(p)[b.place(voxel)] : 0.0F;
  }
  void clear();

  BrickPool* pool_;
  std::array<Brick, kBlockBricks> bricks_;
};

}  // namespace panoptic
