// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Takes down in free space what a frame sees to be empty, and finds what it looks through.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "panoptic/base/config.h"
#include "panoptic/frame.h"
#include "panoptic/fusion/carving.h"
#include "panoptic/fusion/frame_view.h"
#include "panoptic/fusion/registration.h"
#include "panoptic/fusion/sight_tiles.h"
#include "panoptic/map.h"
#include "panoptic/options.h"

namespace panoptic {

Fields fields(CarvingOptions& options);

// A cell is empty if three quarters of the pixels around it, up to two voxels to each side, have a reading, and all of these are
// from behind it by two voxels and the camera's error. It is occupied if a reading lies in it; one pixel in 8 x 8 is asked. The
// cells of a frame are worked out in parallel, chunk by chunk, and written by one thread: the same at any thread count.
class SpaceObserver {
 public:
  SpaceObserver(const MapOptions& map, const CarvingOptions& carving)
      : records_(map.free_space && map.voxel_size_m >= kLeastVoxel_m), views_(carving.enabled ? carving.views : 0) {}

  // Sees a frame that has just been integrated; `time` counts the frames before it. A frame from nearly where the last one was
  // taken tells nothing new: it counts if the camera has moved by 5 cm, has turned by 3 degrees, or 10 frames have passed.
  // `settled`: cells of free space, ascending, in which something came to stay, and of which the frame has no readings. Returns
  // the voxels that are to be cleared, good until the next call.
  const std::vector<CarvedVoxels>& see(const Frame& frame, const RegisteredFrame& registered, std::uint64_t time,
                                       std::span<const CellIndex> settled, PanopticMap& map);
  // Cells that two views or more had seen to be empty, and in which the last frame saw something.
  const std::vector<CellIndex>& came_up() const { return came_up_; }

 private:
  // With smaller voxels a view has so many cells that to look at them takes longer than the rest of fusion.
  static constexpr float kLeastVoxel_m = 0.015F;
  // A view that may reach more chunks is left out: nobody sees 60 m in all directions.
  static constexpr double kMostChunks = 4096;
  static constexpr std::size_t kShares = 16;  // of the rows; fixed, so that nothing depends on the thread count

  // Cells of a voxel block, a bit each.
  struct BlockSight {
    BlockIndex block;
    std::uint64_t cells = 0;
  };
  struct ChunkSight {
    std::vector<BlockSight> empty;
    std::vector<BlockSight> looked;  // their bricks were asked for what is looked through
    std::vector<BrickSight> bricks;
  };

  void find_chunks(const FrameView& view, float chunk_m);
  void look_into(const FrameView& view, BlockIndex chunk, const PanopticMap& map, ChunkSight& sight) const;
  void look_around(const FrameView& view, const PanopticMap& map);
  void find_occupied(const FrameView& view, float cell_m);
  void note_coming_up(BlockIndex block, std::uint64_t cells, const FreeSpaceMap& space);
  void record(std::span<const CellIndex> settled, PanopticMap& map);

  bool records_;
  int views_;  // 0: nothing is carved
  SightTiles tiles_;
  std::vector<BlockIndex> chunks_;
  std::vector<ChunkSight> sights_;
  std::vector<std::vector<BlockSight>> occupied_;  // per share of the rows
  std::vector<BrickSight> bricks_;
  std::vector<CarvedVoxels> carved_;
  std::vector<CellIndex> came_up_;
};

}  // namespace panoptic
