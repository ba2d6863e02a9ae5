// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/ray_kernels.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>

#include "panoptic/base/clones.h"
#include "panoptic/fusion/ray_walk.h"
#include "panoptic/map/block_key.h"
#include "panoptic/voxel_map.h"

namespace panoptic {

Vec3f camera_in_voxels(const FrameView& view, float voxel_size_m) {
  return (view.camera_in_world_m / double{voxel_size_m}).cast<float>();
}

void RayTable::resize(std::size_t pixels) {
  for (std::vector<float>& plane : direction) plane.resize(pixels);
  range.resize(pixels);
}

void PassageLists::clear() {
  recent_.fill({});
  list_of_key_.clear();
  for (std::size_t i = 0; i < keys_.size(); ++i) lists_[i].used = 0;
  keys_.clear();
}

std::uint32_t PassageLists::list_of(std::uint64_t block_key) {
  Recent& recent = recent_[mixed(block_key) % kRecent];
  if (recent.key == block_key) return recent.list;
  const auto [place, is_new] = list_of_key_.try_emplace(block_key, static_cast<std::uint32_t>(keys_.size()));
  if (is_new) {
    keys_.push_back(block_key);
    if (lists_.size() < keys_.size()) lists_.emplace_back();
  }
  recent = {block_key, place->second};
  return place->second;
}

std::uint16_t* PassageLists::append(std::uint64_t block_key, std::uint32_t pixel, std::size_t voxels) {
  List& list = lists_[list_of(block_key)];
  const std::size_t at = list.used;
  list.used += kPassageHead + voxels;
  if (list.used > list.words.size()) list.words.resize(list.used + list.used / 2);  // the vector's own growth sets each word to 0
  list.words[at] = static_cast<std::uint16_t>(pixel);
  list.words[at + 1] = static_cast<std::uint16_t>(pixel >> 16);
  list.words[at + 2] = static_cast<std::uint16_t>(voxels);
  return list.words.data() + at + kPassageHead;
}

std::span<const std::uint16_t> PassageLists::passages(std::uint64_t block_key) const {
  const auto found = list_of_key_.find(block_key);
  if (found == list_of_key_.end()) return {};
  const List& list = lists_[found->second];
  return std::span(list.words).first(list.used);
}

namespace kernels {

// One row of pixels: where the bands along their rays begin and end, in voxels.
struct BandRow {
  std::array<std::vector<float>, 3> to_surface;  // from the camera
  std::array<std::vector<float>, 3> begin;
  std::array<std::vector<float>, 3> end;
  std::vector<std::int32_t> usable;
};

// The ray of column k at depth 1 is per_x * x[k] + base.
struct RowOfRays {
  float per_x[3], base[3], origin[3];
  float voxel_size_m, half_band;  // the latter in voxels
  std::size_t count;
};

// The row's part of the table.
struct TableRow {
  float* direction[3];
  float* range;
};

void cast_band_row(const RowOfRays& rays, const float* x, const float* depth, const TableRow& table, BandRow& row);

PANOPTIC_CLONES
void cast_band_row(const RowOfRays& rays, const float* x, const float* depth, const TableRow& table, BandRow& row) {
  constexpr auto kLimit = static_cast<float>((kMaxBlockCoordinate - 2) * kBlockSide);
  const RowOfRays r = rays;
  const float* __restrict xs = x;
  const float* __restrict zs = depth;
  for (std::size_t a = 0; a < 3; ++a) {
    float* __restrict to_surface = row.to_surface[a].data();
    for (std::size_t k = 0; k < r.count; ++k) to_surface[k] = (r.per_x[a] * xs[k] + r.base[a]) * (zs[k] / r.voxel_size_m);
  }
  const float* __restrict sx = row.to_surface[0].data();
  const float* __restrict sy = row.to_surface[1].data();
  const float* __restrict sz = row.to_surface[2].data();
  float* __restrict range = table.range;
  std::int32_t* __restrict usable = row.usable.data();
  for (std::size_t k = 0; k < r.count; ++k) {
    range[k] = std::sqrt(sx[k] * sx[k] + (sy[k] * sy[k] + sz[k] * sz[k]));
    usable[k] = zs[k] > 0 ? 1 : 0;
  }
  for (std::size_t a = 0; a < 3; ++a) {
    const float* __restrict to_surface = row.to_surface[a].data();
    float* __restrict begin = row.begin[a].data();
    float* __restrict end = row.end[a].data();
    float* __restrict direction = table.direction[a];
    for (std::size_t k = 0; k < r.count; ++k) {
      direction[k] = to_surface[k] / range[k];
      const float surface = r.origin[a] + to_surface[k];
      const float half = direction[k] * r.half_band;
      begin[k] = surface - half;
      end[k] = surface + half;
    }
    for (std::size_t k = 0; k < r.count; ++k) {
      usable[k] &= ((begin[k] < kLimit) & (begin[k] > -kLimit) & (end[k] < kLimit) & (end[k] > -kLimit)) ? 1 : 0;
    }
  }
}

}  // namespace kernels

namespace {

struct CellRange {
  std::size_t begin;
  std::size_t end;
};

// Adds the cells [begin, end) along a ray, which lie in one block.
void add_passage(const CellWalks& walks, std::size_t lane, std::uint32_t pixel, CellRange cells, PassageLists& lists) {
  const auto block_of = [&](std::size_t a) { return walks.cell[a][cells.begin][lane] >> 4; };
  std::uint16_t* voxels = lists.append(pack({block_of(0), block_of(1), block_of(2)}), pixel, cells.end - cells.begin);
  for (std::size_t i = cells.begin; i < cells.end; ++i) *voxels++ = walks.offset[i][lane];
}

// Divides the cells along a ray by block, and adds them to the lists.
void add_passages(const CellWalks& walks, std::size_t lane, std::uint32_t pixel, PassageLists& lists) {
  constexpr std::size_t kWord = 32;
  const auto cells = std::min(static_cast<std::size_t>(walks.count[lane]), kMostCells);
  std::size_t begin = 0;
  for (std::size_t word = 0; word * kWord < cells; ++word) {
    std::uint32_t borders = walks.borders[word][lane];
    const std::size_t left = cells - word * kWord;
    if (left < kWord) borders &= (1U << left) - 1U;
    for (; borders != 0; borders &= borders - 1) {
      const std::size_t end = word * kWord + static_cast<std::size_t>(std::countr_zero(borders));
      add_passage(walks, lane, pixel, {begin, end}, lists);
      begin = end;
    }
  }
  add_passage(walks, lane, pixel, {begin, cells}, lists);
}

void walk_row(const kernels::BandRow& row, std::uint32_t first_pixel, CellWalks& walks, PassageLists& lists) {
  const std::size_t width = row.usable.size();
  for (std::size_t begin = 0; begin < width; begin += kWalkLanes) {
    const std::size_t count = std::min(kWalkLanes, width - begin);
    for (std::size_t lane = 0; lane < kWalkLanes; ++lane) {
      const std::size_t k = std::min(begin + lane, width - 1);
      const bool walked = lane < count && row.usable[k] != 0;
      for (std::size_t a = 0; a < 3; ++a) {
        walks.start[a][lane] = walked ? row.begin[a][k] : 0.0F;
        walks.end[a][lane] = walked ? row.end[a][k] : 0.0F;
      }
    }
    walk_together(walks);
    for (std::size_t lane = 0; lane < count; ++lane) {
      if (row.usable[begin + lane] == 0) continue;
      add_passages(walks, lane, first_pixel + static_cast<std::uint32_t>(begin + lane), lists);
    }
  }
}

kernels::BandRow row_buffers(std::size_t width) {
  kernels::BandRow row;
  row.usable.resize(width);
  for (std::size_t a = 0; a < 3; ++a) {
    row.to_surface[a].resize(width);
    row.begin[a].resize(width);
    row.end[a].resize(width);
  }
  return row;
}

}  // namespace

void collect_passages(const FrameView& view, RowRange rows, const RayBand& band, RayTable& rays, PassageLists& lists) {
  const auto width = static_cast<std::size_t>(view.pixels.width);
  std::vector<float> x(width);
  for (std::size_t u = 0; u < width; ++u) x[u] = static_cast<float>((static_cast<double>(u) - view.camera.cx) / view.camera.fx);
  kernels::BandRow row = row_buffers(width);
  kernels::RowOfRays of_row{};
  of_row.voxel_size_m = band.voxel_size_m;
  of_row.half_band = band.band.truncation_m / band.voxel_size_m;
  of_row.count = width;
  const Vec3f origin = camera_in_voxels(view, band.voxel_size_m);
  const auto walks = std::make_unique<CellWalks>();
  for (int v = rows.begin; v < rows.end; ++v) {
    const auto y = static_cast<float>((v - view.camera.cy) / view.camera.fy);
    const std::size_t first = view.index(0, v);
    kernels::TableRow table{{}, rays.range.data() + first};
    for (int a = 0; a < 3; ++a) {
      of_row.origin[a] = origin[a];
      of_row.per_x[a] = view.world_from_camera(a, 0);
      of_row.base[a] = view.world_from_camera(a, 1) * y + view.world_from_camera(a, 2);
      table.direction[a] = rays.direction[static_cast<std::size_t>(a)].data() + first;
    }
    kernels::cast_band_row(of_row, x.data(), view.pixels.depth + first, table, row);
    walk_row(row, static_cast<std::uint32_t>(first), *walks, lists);
  }
}

}  // namespace panoptic
