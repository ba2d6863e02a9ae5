// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The space that was seen to be empty: coarse cells in chunks of 16^3, four bytes a cell. Voxels tell what is near a surface;
// cells tell of the rest whether a camera looked through it.
//
// Threads: const functions may run side by side, all others need the map for themselves.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/voxel_map.h"

namespace panoptic {

enum class Space : std::uint8_t { kUnknown, kFree, kOccupied };

// Cell c spans [c, c + 1) * cell_size_m in the world, on each axis. A cell is a brick of voxels.
using CellIndex = std::array<std::int32_t, 3>;
inline constexpr int kCellVoxels = 4;

// The cells of one voxel block, 4^3 of them, have the numbers of its bricks (voxel_block.h).
inline constexpr int kBlockCells = 64;
constexpr CellIndex cell_of(BlockIndex block, int number) {
  return {block.x * 4 + (number & 3), block.y * 4 + (number >> 2 & 3), block.z * 4 + (number >> 4)};
}

// All that is known of a cell. Times count the frames that were used; they are rounded down to a multiple of
// FreeSpaceMap::frames_per_tick.
struct CellRecord {
  // Views that saw it empty, at most kMostEmpty; every view that saw something in it halves that and takes 2 off, down to
  // -kMostOccupied.
  int evidence = 0;
  std::optional<std::uint64_t> empty_at;  // when it was last seen so; nothing: never
  std::optional<std::uint64_t> occupied_at;

  bool operator==(const CellRecord&) const = default;
};
inline constexpr int kMostEmpty = 100;
inline constexpr int kMostOccupied = 4;

// Voxels of a cell that were looked through although they hold a surface, each by up to 7 views: bit planes of the counts, a bit
// for each voxel of the brick.
struct Doubt {
  std::array<std::uint64_t, 3> count{};
  Vec3f seen_from_m = Vec3f::Zero();  // the camera of the last view that was counted

  bool operator==(const Doubt&) const = default;
};

// The frame from which free space was last updated.
struct SpaceView {
  Vec3d camera_m = Vec3d::Zero();
  Vec3d axis = Vec3d::UnitZ();  // optical, in the world
  std::uint64_t time = 0;       // frames that were used before it

  bool operator==(const SpaceView&) const = default;
};

// The cells of a chunk, as the map keeps and files store them: those of 4^3 voxel blocks, of which the ones that were ever seen
// are there.
struct SpaceChunk {
  using Cells = std::array<std::uint32_t, kBlockCells>;  // evidence, and both times: FreeSpaceMap::at and record read them

  BlockIndex index;                                 // of its first voxel block, divided by 4
  std::uint64_t present = 0;                        // a bit per voxel block, numbered like bricks
  std::vector<Cells> blocks;                        // those, ascending
  std::vector<std::pair<CellIndex, Doubt>> doubts;  // ascending
};

class FreeSpaceMap {
 public:
  explicit FreeSpaceMap(float voxel_size_m) : cell_size_m_(voxel_size_m * kCellVoxels) {}

  float cell_size_m() const { return cell_size_m_; }
  // Nothing was ever recorded: a map of an older format, or a run with map.free_space off.
  bool empty() const { return !last_view_.has_value(); }

  Space at(const CellIndex& cell) const;
  CellRecord record(const CellIndex& cell) const;
  // The cell around a point, world; nothing if it lies farther out than a map reaches.
  std::optional<CellIndex> cell_around(const Vec3d& point_m) const;

  // The cells of a voxel block, to read them with map/space_cells.h; nullptr if none was ever seen.
  const SpaceChunk::Cells* cells_of(BlockIndex block) const;

  // The lowest and the highest coordinates of cells that are not unknown; nothing if there are none.
  std::optional<std::pair<CellIndex, CellIndex>> bounds() const;
  // Calls visit for every cell that is not unknown, in an order that depends on the cells alone.
  void for_each(const std::function<void(const CellIndex&, Space)>& visit) const;

  std::size_t memory_bytes() const;
  // A fingerprint of all cells, doubts and the last view, whatever the order in which chunks were made.
  std::uint64_t hash() const;

  const std::optional<SpaceView>& last_view() const { return last_view_; }
  std::uint64_t frames_per_tick() const { return std::uint64_t{1} << log2_; }

  // One view: begin_view, and then `observe` for blocks of cells that it saw empty or something in, a bit per cell. A cell must
  // not be both. Chunks are stamped with the epoch. REQUIRES in_range(block) and times that do not fall.
  void begin_view(const SpaceView& view, std::uint64_t epoch);
  void observe(BlockIndex block, std::uint64_t empty, std::uint64_t occupied);

  // The doubts about surfaces (fusion/carving.h).
  const Doubt* doubt(const CellIndex& cell) const;
  std::uint64_t doubted(BlockIndex block) const;  // a bit per cell
  void set_doubt(const CellIndex& cell, const Doubt& doubt);
  void drop_doubt(const CellIndex& cell);
  std::size_t doubt_count() const { return doubts_.size(); }

  // Adds what another map of the same cell size saw; its times come after those of this one.
  void merge(const FreeSpaceMap& later);

  // For files: chunks that changed after the epoch, in the order of their places; and a map of such chunks. `put` REQUIRES a
  // chunk that is sound (is_sound) and not there yet.
  std::vector<SpaceChunk> changed_since(std::uint64_t epoch) const;
  void put(const SpaceChunk& chunk);
  int log2_frames_per_tick() const { return log2_; }
  void restore_view(const SpaceView& view, int log2_frames_per_tick);
  static bool is_sound(const SpaceChunk& chunk);

 private:
  // The cells of a chunk that were ever seen.
  struct Chunk {
    BlockIndex index;
    std::uint64_t present = 0;
    std::uint64_t changed_at = 0;
    std::vector<SpaceChunk::Cells> blocks;

    std::size_t place(int block) const;
  };

  const Chunk* find(BlockIndex block) const;
  Chunk& chunk_of(BlockIndex block);
  SpaceChunk::Cells& cells(BlockIndex block);
  std::vector<const Chunk*> ordered() const;
  void halve_times();

  float cell_size_m_;
  int log2_ = 0;
  std::uint64_t epoch_ = 1;
  std::optional<SpaceView> last_view_;
  std::vector<Chunk> chunks_;
  std::unordered_map<std::uint64_t, std::uint32_t> chunk_at_;  // by key: the place in chunks_
  std::map<CellIndex, Doubt> doubts_;
  std::unordered_map<std::uint64_t, std::uint64_t> doubted_;  // by key of a voxel block: a bit per cell
};

}  // namespace panoptic
