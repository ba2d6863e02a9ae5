// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/space_observer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "panoptic/map/block_key.h"
#include "panoptic/map/space_cells.h"
#include "panoptic/map/voxel_grid.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr double kMoved_m = 0.05;
constexpr double kTurned_deg = 3;
constexpr std::uint64_t kFramesAtRest = 10;
// Views that saw a cell empty before something came up there: one may err, two seldom err in the same way.
constexpr int kFreeViews = 2;

// Depth cameras lose pixels at every edge; what gives no reading at all is wider.
constexpr float kMostMissing = 0.25F;

constexpr float kHalfCell_voxels = 0.5F * kCellVoxels;
// Boxes around cells, in voxels, and around voxel blocks, in cells.
constexpr float kHalfBox_voxels = kHalfCell_voxels + kClearance_voxels;
constexpr float kHalfBlock_cells = 2 + kClearance_voxels / kCellVoxels;

bool is_new(const SpaceView& view, const std::optional<SpaceView>& last) {
  if (!last || view.time >= last->time + kFramesAtRest) return true;
  static const double kLeastCosine = std::cos(kTurned_deg * std::numbers::pi / 180);
  return (view.camera_m - last->camera_m).norm() > kMoved_m || view.axis.dot(last->axis) < kLeastCosine;
}

// The planes through the camera that bound its view, inwards, in the world.
std::array<Vec3f, 4> side_planes(const FrameView& view) {
  const Camera& c = view.camera;
  const auto inward = [&](double x, double y, double z) {
    const Vec3f in_camera = Vec3d(x, y, z).normalized().cast<float>();
    return Vec3f(view.world_from_camera * in_camera);
  };
  return {inward(c.fx, 0, c.cx), inward(-c.fx, 0, c.width - 1 - c.cx), inward(0, c.fy, c.cy),
          inward(0, -c.fy, c.height - 1 - c.cy)};
}

// Half the extent along the optical axis of a box that reaches so many steps from its middle.
float half_depth_m(const BlockInCamera& grid, float half_steps) {
  return half_steps * (std::abs(grid.step_x[2]) + std::abs(grid.step_y[2]) + std::abs(grid.step_z[2]));
}

// A box that is empty for certain: every pixel says so.
bool is_certainly_empty(const SightTiles& tiles, const BoxesInView& boxes, int n) {
  if (boxes.whole[n] == 0) return false;
  return tiles.certain_m(boxes.pixels(n)) > boxes.farthest_m[n] + depth_error_m(boxes.farthest_m[n]);
}

// Most pixels say so, and none says anything else.
bool is_seen_empty(const SightTiles& tiles, const BoxesInView& boxes, int n) {
  if (boxes.whole[n] == 0) return false;
  const PixelArea pixels = boxes.pixels(n);
  return tiles.nearest_m(pixels) > boxes.farthest_m[n] + depth_error_m(boxes.farthest_m[n]) &&
         tiles.missing(pixels) < kMostMissing;
}

// The cells of a voxel block that are seen to be empty.
std::uint64_t empty_cells(const FrameView& view, const SightTiles& tiles, BlockIndex block, float voxel_m) {
  const BlockInCamera grid = view.in_camera(block, voxel_m);
  BoxesInView boxes;  // NOLINT(cppcoreguidelines-pro-type-member-init): filled by find_boxes
  kernels::find_boxes(view.pixels, grid, kHalfBox_voxels, boxes);
  std::uint64_t empty = 0;
  for (int n = 0; n < kBlockCells; ++n) empty |= std::uint64_t{is_seen_empty(tiles, boxes, n)} << n;
  return empty;
}

// The lowest and the highest coordinates of what the view may reach.
std::pair<Vec3d, Vec3d> bounds_of(const FrameView& view) {
  Vec3d low = view.camera_in_world_m;
  Vec3d high = low;
  for (const int u : {0, view.pixels.width - 1}) {
    for (const int v : {0, view.pixels.height - 1}) {
      const Vec3d corner = view.camera_in_world_m + (view.ray(u, v) * view.farthest_m).cast<double>();
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
  }
  return {low, high};
}

}  // namespace

Fields fields(CarvingOptions& o) {
  return {
      {"enabled", &o.enabled, "clear voxels that the camera looks through; needs map.free_space", {}},
      {"views", &o.views, "places from which it must look through them, with no surface seen there meanwhile", in_range(1, 7)}};
}

const std::vector<CarvedVoxels>& SpaceObserver::see(const Frame& frame, const RegisteredFrame& registered, std::uint64_t time,
                                                    std::span<const CellIndex> settled, PanopticMap& map) {
  carved_.clear();
  came_up_.clear();
  const FrameView view = depth_view(frame, registered);
  const SpaceView now{view.camera_in_world_m, frame.world_from_camera.linear().col(2), time};
  if (!records_ || !is_new(now, map.free_space.last_view())) return carved_;
  tiles_.build(view.pixels.depth, view.pixels.width, view.pixels.height);
  find_chunks(view, map.free_space.cell_size_m() * kBlockSide);
  sights_.resize(std::max(sights_.size(), chunks_.size()));
  parallel_for(chunks_.size(), [&](std::size_t i) { look_into(view, chunks_[i], map, sights_[i]); });
  find_occupied(view, map.free_space.cell_size_m());
  map.free_space.begin_view(now, map.voxels.epoch());
  record(settled, map);
  look_around(view, map);
  if (views_ > 0) carved_ = carve(bricks_, now.camera_m, views_, map.free_space);
  return carved_;
}

// Those that the view may reach, in the order of their places.
void SpaceObserver::find_chunks(const FrameView& view, float chunk_m) {
  chunks_.clear();
  const auto [low, high] = bounds_of(view);
  const Eigen::Vector3i first = (low / double{chunk_m}).array().floor().cast<int>();
  const Eigen::Vector3i last = (high / double{chunk_m}).array().floor().cast<int>();
  if (((last - first).cast<double>().array() + 1).prod() > kMostChunks) return;
  const std::array<Vec3f, 4> planes = side_planes(view);
  const Vec3f axis = view.world_from_camera.col(2);
  const float radius_m = chunk_m * 0.87F;  // half the diagonal
  const auto may_see = [&](const Vec3f& from_camera) {
    const float depth = axis.dot(from_camera);
    return depth > -radius_m && depth < view.farthest_m + radius_m &&
           std::all_of(planes.begin(), planes.end(), [&](const Vec3f& inward) { return inward.dot(from_camera) > -radius_m; });
  };
  for (int z = first.z(); z <= last.z(); ++z) {
    for (int y = first.y(); y <= last.y(); ++y) {
      for (int x = first.x(); x <= last.x(); ++x) {
        const Vec3d middle_m = (Vec3d(x, y, z) + Vec3d::Constant(0.5)) * double{chunk_m};
        if (may_see((middle_m - view.camera_in_world_m).cast<float>())) chunks_.push_back({x, y, z});
      }
    }
  }
}

void SpaceObserver::look_into(const FrameView& view, BlockIndex chunk, const PanopticMap& map, ChunkSight& sight) const {
  sight.empty.clear();
  sight.looked.clear();
  sight.bricks.clear();
  const SightOfBlock of_block{view, tiles_, map};
  const BlockInCamera grid = view.in_camera(chunk, map.free_space.cell_size_m());
  BoxesInView boxes;  // NOLINT(cppcoreguidelines-pro-type-member-init): filled by find_boxes
  kernels::find_boxes(view.pixels, grid, kHalfBlock_cells, boxes);
  const float whole_m = 2 * half_depth_m(grid, kHalfBox_voxels / kCellVoxels);  // through one cell with what is around it
  for (int n = 0; n < kBlockBricks; ++n) {
    const BlockIndex block = block_in(chunk, n);
    if (boxes.pixels(n).is_empty() || !in_range(block)) continue;
    const Slot slot = views_ > 0 ? map.voxels.find_slot(block) : VoxelMap::kNoSlot;
    std::uint64_t empty = 0;
    if (is_certainly_empty(tiles_, boxes, n)) {
      empty = ~std::uint64_t{0};
    } else if (tiles_.farthest_m(boxes.pixels(n)) > boxes.nearest_m[n] + whole_m) {
      empty = empty_cells(view, tiles_, block, map.voxels.voxel_size_m());
    }
    if (empty != 0) sight.empty.push_back({block, empty});
    const std::uint64_t bricks = slot == VoxelMap::kNoSlot ? 0 : empty | map.free_space.doubted(block);
    if (bricks == 0) continue;
    sight.looked.push_back({block, bricks});
    of_block.look(slot, bricks, sight.bricks);
  }
}

// Where something was looked through, the bricks around may be too, although their cells are not empty as a whole: the rim of
// what was there.
void SpaceObserver::look_around(const FrameView& view, const PanopticMap& map) {
  std::map<BlockIndex, std::uint64_t> around;
  for (const BrickSight& sight : bricks_) {
    if (sight.through == 0) continue;
    const CellIndex cell = cell_of(sight.block, sight.brick);
    for (int n = 0; n < kNeighbours; ++n) {
      const BlockIndex step = step_to(n);
      const CellIndex beside{cell[0] + step.x, cell[1] + step.y, cell[2] + step.z};
      around[block_of(beside)] |= std::uint64_t{1} << number_of(beside);
    }
  }
  if (around.empty()) return;
  for (std::size_t i = 0; i < chunks_.size(); ++i) {
    for (const BlockSight& looked : sights_[i].looked) {
      if (const auto found = around.find(looked.block); found != around.end()) found->second &= ~looked.cells;
    }
  }
  const SightOfBlock of_block{view, tiles_, map};
  for (const auto& [block, bricks] : around) {
    const Slot slot = map.voxels.find_slot(block);
    if (slot != VoxelMap::kNoSlot) of_block.look(slot, bricks, bricks_);
  }
}

void SpaceObserver::find_occupied(const FrameView& view, float cell_m) {
  constexpr int kStride_px = 8;
  const auto samples = static_cast<std::size_t>((view.pixels.height + kStride_px - 1) / kStride_px);
  occupied_.resize(kShares);
  parallel_for(kShares, [&](std::size_t share) {
    std::vector<BlockSight>& found = occupied_[share];
    found.clear();
    for (std::size_t row = samples * share / kShares; row < samples * (share + 1) / kShares; ++row) {
      const int v = std::min(static_cast<int>(row) * kStride_px + kStride_px / 2, view.pixels.height - 1);
      for (int u = kStride_px / 2; u < view.pixels.width; u += kStride_px) {
        const float z = view.pixels.depth[view.index(u, v)];
        if (!(z > 0)) continue;
        const Vec3d place = (view.camera_in_world_m + (view.ray(u, v) * z).cast<double>()) / double{cell_m};
        const Eigen::Vector3i c = place.array().floor().cast<int>();
        const CellIndex cell{c.x(), c.y(), c.z()};
        const BlockIndex block = block_of(cell);
        if (found.empty() || found.back().block != block) found.push_back({block, 0});
        found.back().cells |= std::uint64_t{1} << number_of(cell);
      }
    }
  });
}

void SpaceObserver::note_coming_up(BlockIndex block, std::uint64_t cells, const FreeSpaceMap& space) {
  const SpaceChunk::Cells* known = space.cells_of(block);
  for (; known != nullptr && cells != 0; cells &= cells - 1) {
    const int n = std::countr_zero(cells);
    if (evidence_of((*known)[static_cast<std::size_t>(n)]) >= kFreeViews) came_up_.push_back(cell_of(block, n));
  }
}

void SpaceObserver::record(std::span<const CellIndex> settled, PanopticMap& map) {
  std::vector<BlockSight> occupied;
  for (const std::vector<BlockSight>& share : occupied_) occupied.insert(occupied.end(), share.begin(), share.end());
  for (const CellIndex& cell : settled) {
    if (in_range(block_of(cell))) occupied.push_back({block_of(cell), std::uint64_t{1} << number_of(cell)});
  }
  std::sort(occupied.begin(), occupied.end(), [](const BlockSight& a, const BlockSight& b) { return a.block < b.block; });
  for (std::size_t i = 0; i < occupied.size();) {
    const BlockIndex block = occupied[i].block;
    std::uint64_t cells = 0;
    for (; i < occupied.size() && occupied[i].block == block; ++i) cells |= occupied[i].cells;
    if (!in_range(block)) continue;
    note_coming_up(block, cells, map.free_space);
    map.free_space.observe(block, 0, cells);
  }
  bricks_.clear();
  for (std::size_t i = 0; i < chunks_.size(); ++i) {
    for (const BlockSight& sight : sights_[i].empty) map.free_space.observe(sight.block, sight.cells, 0);
    bricks_.insert(bricks_.end(), sights_[i].bricks.begin(), sights_[i].bricks.end());
  }
}

}  // namespace panoptic
