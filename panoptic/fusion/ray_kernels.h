// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Finds the voxels that the rays of a frame pass through, block by block.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "panoptic/fusion/frame_view.h"
#include "panoptic/voxel_map.h"

namespace panoptic {

struct RayBand {
  Band band;
  float voxel_size_m;
};

// The place of the camera.
Vec3f camera_in_voxels(const FrameView& view, float voxel_size_m);

// The rays of all pixels, for the signed distance: unit direction in the world, and range from the camera to the surface in
// voxels. One plane per number, indexed by pixel; meaningless where there is no depth.
struct RayTable {
  std::array<std::vector<float>, 3> direction;
  std::vector<float> range;

  void resize(std::size_t pixels);
};

constexpr std::size_t kPassageHead = 3;  // words before the voxels
constexpr std::size_t kMostVoxels = 64;  // of one passage; a straight line through a block has at most 46

// The voxels that the rays of some pixels pass through, by block. The list of a block is a row of passages, each of them 16-bit
// words: pixel (low, high), number of voxels, then the offset of each voxel in its block, in the order along the ray.
class PassageLists {
 public:
  // Forgets all passages and keeps the memory.
  void clear();
  // Adds a passage at the end of its block's list. Returns where its voxels are to be written, at once.
  std::uint16_t* append(std::uint64_t block_key, std::uint32_t pixel, std::size_t voxels);

  // Keys of the blocks, in the order in which they came up.
  std::span<const std::uint64_t> keys() const { return keys_; }
  // The passages of a block; none if no ray crosses it.
  std::span<const std::uint16_t> passages(std::uint64_t block_key) const;

 private:
  std::uint32_t list_of(std::uint64_t block_key);

  static constexpr std::size_t kRecent = 64;
  struct Recent {
    std::uint64_t key = ~std::uint64_t{0};
    std::uint32_t list = 0;
  };
  std::array<Recent, kRecent> recent_{};
  std::unordered_map<std::uint64_t, std::uint32_t> list_of_key_;
  std::vector<std::uint64_t> keys_;
  struct List {
    std::vector<std::uint16_t> words;  // more than are in use
    std::size_t used = 0;
  };
  std::vector<List> lists_;  // the first keys_.size() are in use
};

// Rows [begin, end) of a frame.
struct RowRange {
  int begin;
  int end;
};

// Walks the rays of some rows through their bands, and fills their part of the table. Pixels without depth or beyond the grid
// are left out.
void collect_passages(const FrameView& view, RowRange rows, const RayBand& band, RayTable& rays, PassageLists& lists);

}  // namespace panoptic
