// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "panoptic/error.h"
#include "panoptic/map/cached_lookup.h"
#include "panoptic/map/space_cells.h"
#include "panoptic/map/voxel_grid.h"
#include "panoptic/map_pairs.h"
#include "panoptic/mapfile/run_notes.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr std::size_t kBlocksAtOnce = 256;  // of 24 bytes a voxel, spread out: 25 MB

// Whole numbers of a grid around a cube of it after a motion; both ends are included. Throws Error if they are not those of
// blocks.
std::pair<Eigen::Vector3i, Eigen::Vector3i> range_of(const Vec3d& corner_m, double edge_m, const Pose& new_from_old) {
  Eigen::AlignedBox3d box;
  for (int n = 0; n < 8; ++n) box.extend(new_from_old * Vec3d(corner_m + edge_m * Vec3d(n & 1, n >> 1 & 1, n >> 2)));
  const double farthest = std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff()) / edge_m;
  if (!(farthest < kMaxBlockCoordinate)) throw Error("the moved map would lie farther from the origin than a map reaches");
  return {(box.min() / edge_m).array().floor().matrix().cast<int>(), (box.max() / edge_m).array().floor().matrix().cast<int>()};
}

// Blocks that may hold something of the moved map, in the order of their places.
std::vector<BlockIndex> blocks_after(const VoxelMap& map, const Pose& new_from_old) {
  std::set<BlockIndex> blocks;
  const double edge_m = map.block_size_m();
  for (Slot slot = 0; slot < map.block_count(); ++slot) {
    const BlockIndex from = map.index_of(slot);
    const auto [low, high] = range_of(Vec3d(from.x, from.y, from.z) * edge_m, edge_m, new_from_old);
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) blocks.insert({x, y, z});
      }
    }
  }
  return {blocks.begin(), blocks.end()};
}

// Reads a map between its voxels: distance and weight as the mean of the eight voxels around a point that were observed, all else
// from the one that is nearest, which must have been.
class Resampler {
 public:
  explicit Resampler(const VoxelMap& map) : lookup_(map), voxel_m_(map.voxel_size_m()) {}

  std::optional<Voxel> at(const Vec3d& point_m) {
    const std::optional<Voxel> nearest = observed(place_of(point_m, voxel_m_));
    if (!nearest) return std::nullopt;
    const Vec3d voxels = point_m / voxel_m_ - Vec3d::Constant(0.5);
    const Vec3d whole = voxels.array().floor();
    const Vec3d t = voxels - whole;
    const Eigen::Vector3i v = whole.cast<int>();
    double distance = 0;
    double weight = 0;
    double share = 0;
    for (int n = 0; n < 8; ++n) {
      const Eigen::Vector3i step(n & 1, n >> 1 & 1, n >> 2);
      const double part =
          (step.x() != 0 ? t.x() : 1 - t.x()) * (step.y() != 0 ? t.y() : 1 - t.y()) * (step.z() != 0 ? t.z() : 1 - t.z());
      const std::optional<Voxel> voxel = observed(place_of(VoxelIndex{v.x() + step.x(), v.y() + step.y(), v.z() + step.z()}));
      if (!voxel || !(part > 0)) continue;
      distance += part * double{voxel->distance};
      weight += part * double{voxel->weight};
      share += part;
    }
    Voxel mean = *nearest;
    mean.distance = static_cast<float>(distance / share);
    mean.weight = static_cast<float>(weight / share);
    return mean;
  }

 private:
  std::optional<Voxel> observed(const std::optional<VoxelPlace>& place) {
    if (!place || !in_range(place->block)) return std::nullopt;
    const VoxelBlock* block = lookup_.find(place->block);
    if (block == nullptr || !(block->weight(place->offset) > 0)) return std::nullopt;
    return block->at(place->offset);
  }

  CachedLookup lookup_;
  double voxel_m_;
};

void put(const Voxel& voxel, std::size_t at, BlockPlanes& planes) {
  planes.distance[at] = voxel.distance;
  planes.weight[at] = voxel.weight;
  planes.label_weight[at] = voxel.label_weight;
  planes.vote_sum[at] = voxel.vote_sum;
  planes.label[at] = voxel.label;
  planes.red[at] = voxel.red;
  planes.green[at] = voxel.green;
  planes.blue[at] = voxel.blue;
}

// Nothing if no voxel of the block is.
std::unique_ptr<BlockPlanes> resampled(const VoxelMap& map, BlockIndex block, const Pose& old_from_new) {
  Resampler old(map);
  std::unique_ptr<BlockPlanes> planes;
  const VoxelIndex first = first_voxel(block);
  for (int offset = 0; offset < kBlockVoxels; ++offset) {
    const auto voxel = old.at(old_from_new * center_m(voxel_at(first, offset), map.voxel_size_m()));
    if (!voxel) continue;
    if (!planes) planes = std::make_unique<BlockPlanes>();
    put(*voxel, static_cast<std::size_t>(offset), *planes);
  }
  return planes;
}

VoxelMap moved_voxels(const VoxelMap& map, const MapOptions& options, const Pose& new_from_old) {
  VoxelMap moved(options);
  const std::vector<BlockIndex> blocks = blocks_after(map, new_from_old);
  const Pose old_from_new = new_from_old.inverse();
  for (std::size_t begin = 0; begin < blocks.size(); begin += kBlocksAtOnce) {
    const std::size_t count = std::min(kBlocksAtOnce, blocks.size() - begin);
    std::vector<std::unique_ptr<BlockPlanes>> planes(count);
    parallel_for(count, [&](std::size_t i) { planes[i] = resampled(map, blocks[begin + i], old_from_new); });
    for (std::size_t i = 0; i < count; ++i) {
      if (planes[i]) moved.block(moved.allocate(blocks[begin + i])).pack(*planes[i]);
    }
  }
  return moved;
}

// A cell of the moved map is as little seen to be empty as the emptiest-looking of the old ones that it lies in allow: all of
// them must be free. It is occupied if the one around its middle is.
std::uint32_t moved_cell(const FreeSpaceMap& old, const CellIndex& cell, const Pose& old_from_new) {
  const double edge_m = old.cell_size_m();
  const auto cell_at = [&](const Vec3d& corner) -> std::uint32_t {
    const auto at = old.cell_around(old_from_new * Vec3d((Vec3d(cell[0], cell[1], cell[2]) + corner) * edge_m));
    const SpaceChunk::Cells* cells = at ? old.cells_of(block_of(*at)) : nullptr;
    return cells == nullptr ? 0U : (*cells)[static_cast<std::size_t>(number_of(*at))];
  };
  std::uint32_t least = cell_at(Vec3d::Constant(0.5));
  if (space_of(least) != Space::kFree) return least;
  for (int n = 0; n < 8; ++n) {
    const std::uint32_t corner = cell_at(Vec3d(n & 1, n >> 1 & 1, n >> 2));
    if (space_of(corner) != Space::kFree) return 0;
    if (evidence_of(corner) < evidence_of(least)) least = corner;
  }
  return least;
}

// The voxel blocks around the cells that were ever seen, by chunk.
std::map<BlockIndex, std::set<BlockIndex>> space_after(const FreeSpaceMap& old, const Pose& new_from_old) {
  std::set<BlockIndex> before;
  old.for_each([&](const CellIndex& cell, Space) { before.insert(block_of(cell)); });
  std::map<BlockIndex, std::set<BlockIndex>> after;
  const double edge_m = old.cell_size_m() * kBlockSide / kCellVoxels;
  for (const BlockIndex& block : before) {
    const auto [low, high] = range_of(Vec3d(block.x, block.y, block.z) * edge_m, edge_m, new_from_old);
    for (int z = low.z(); z <= high.z(); ++z) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int x = low.x(); x <= high.x(); ++x) after[chunk_of(BlockIndex{x, y, z})].insert({x, y, z});
      }
    }
  }
  return after;
}

FreeSpaceMap moved_space(const FreeSpaceMap& old, float voxel_size_m, const Pose& new_from_old) {
  FreeSpaceMap moved(voxel_size_m);
  if (old.empty()) return moved;
  const Pose old_from_new = new_from_old.inverse();
  for (const auto& [index, blocks] : space_after(old, new_from_old)) {
    std::map<int, SpaceChunk::Cells> by_number;
    for (const BlockIndex& block : blocks) {
      SpaceChunk::Cells cells{};
      for (int n = 0; n < kBlockCells; ++n) cells[static_cast<std::size_t>(n)] = moved_cell(old, cell_of(block, n), old_from_new);
      if (std::any_of(cells.begin(), cells.end(), [](std::uint32_t cell) { return cell != 0; }))
        by_number[number_of(block)] = cells;
    }
    SpaceChunk chunk;
    chunk.index = index;
    for (const auto& [number, cells] : by_number) {
      chunk.present |= std::uint64_t{1} << number;
      chunk.blocks.push_back(cells);
    }
    if (chunk.present != 0) moved.put(chunk);
  }
  SpaceView view = *old.last_view();
  view.camera_m = new_from_old * view.camera_m;
  view.axis = new_from_old.linear() * view.axis;
  moved.restore_view(view, old.log2_frames_per_tick());
  return moved;
}

// Keeps the part of the run's state that regularizing a file needs: nothing that lies somewhere.
void move_notes(const SavedMap& old, const Pose& new_from_old, MapNotes& notes) {
  notes.texts[run_note::kUp] = up_text(new_from_old.linear() * up_of(old));
  if (old.notes.states.empty()) return;
  const SavedState before = saved_state(old);
  SavedState after;
  after.label_frames = before.label_frames;
  after.labelled = before.labelled;
  after.last_frame = before.last_frame;
  after.up_sum = new_from_old.linear() * before.up_sum;
  MapNotes state = notes_of(after);
  notes.states = std::move(state.states);
  for (auto& [name, text] : state.texts) notes.texts[name] = std::move(text);
}

}  // namespace

MapWithFrames moved_map(const MapWithFrames& map, const Pose& new_from_old) {
  const SavedMap& old = map.saved;
  SavedMap saved{old.options,
                 PanopticMap(old.map.labels, moved_voxels(old.map.voxels, old.options, new_from_old), old.map.objects), old.notes,
                 old.format};
  saved.map.free_space = moved_space(old.map.free_space, old.map.voxels.voxel_size_m(), new_from_old);
  move_notes(old, new_from_old, saved.notes);
  MapWithFrames moved{std::move(saved), map.frames};
  for (FrameRecord& frame : moved.frames) {
    if (frame.world_from_camera) frame.world_from_camera = new_from_old * *frame.world_from_camera;
  }
  return moved;
}

}  // namespace panoptic
