// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/band_touch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "panoptic/base/clones.h"
#include "panoptic/base/floor.h"
#include "panoptic/map/block_key.h"
#include "panoptic/parallel.h"

namespace panoptic {

namespace kernels {

// A row of sampled pixels: columns and depths in, block coordinates of one sample of each band out.
struct TouchRow {
  std::vector<float> depth;
  std::vector<float> middle[3];     // the surface point, in blocks
  std::vector<float> direction[3];  // of the ray, unit length
  std::vector<float> place;         // one coordinate of the sample, in blocks
  std::vector<std::int32_t> block[3];
  std::vector<std::uint8_t> changed;  // 0 where the block is that of the pixel before
  std::size_t count = 0;
};

// The ray of column k at depth 1 is x[k] * per_x + (y * per_y + per_z), in blocks; seen from the camera at `origin`.
struct RowRays {
  float per_x[3], per_y[3], per_z[3], origin[3];
  float y;
  float blocks_per_metre;
};

// The coordinate of what touches no block: beyond the grid, within int32 and exact in float.
constexpr std::int32_t kNowhere = -(1 << 30);
constexpr float kOffGrid = kNowhere;

void cast_row(const RowRays& rays, const float* x, TouchRow& row);
void sample_row(float along, TouchRow& row);

PANOPTIC_CLONES
void cast_row(const RowRays& rays, const float* x, TouchRow& row) {
  const RowRays r = rays;
  const float* __restrict xs = x;
  const float* __restrict zs = row.depth.data();
  const std::size_t count = row.count;
  for (int a = 0; a < 3; ++a) {  // axis by axis: with more pointers in a loop GCC gives up on telling them apart
    float* __restrict middle = row.middle[a].data();
    float* __restrict ray = row.direction[a].data();
    const float base = r.per_y[a] * r.y + r.per_z[a];
    for (std::size_t k = 0; k < count; ++k) {
      const float along = (r.per_x[a] * xs[k] + base) * r.blocks_per_metre;
      ray[k] = along;
      middle[k] = r.origin[a] + along * zs[k];
    }
  }
  float* __restrict dx = row.direction[0].data();
  float* __restrict dy = row.direction[1].data();
  float* __restrict dz = row.direction[2].data();
  for (std::size_t k = 0; k < count; ++k) {
    const float length = std::sqrt(dx[k] * dx[k] + (dy[k] * dy[k] + dz[k] * dz[k]));
    dx[k] /= length;
    dy[k] /= length;
    dz[k] /= length;
  }
}

// The blocks at this distance from the surface, in blocks; kNowhere for pixels without depth or beyond the grid.
PANOPTIC_CLONES
void sample_row(float along, TouchRow& row) {
  constexpr auto kLimit = static_cast<float>(kMaxBlockCoordinate - 2);
  const std::size_t count = row.count;
  const float* __restrict zs = row.depth.data();
  std::int32_t* __restrict bx = row.block[0].data();
  std::int32_t* __restrict by = row.block[1].data();
  std::int32_t* __restrict bz = row.block[2].data();
  std::uint8_t* __restrict changed = row.changed.data();
  for (int a = 0; a < 3; ++a) {
    const float* __restrict middle = row.middle[a].data();
    const float* __restrict direction = row.direction[a].data();
    float* __restrict place = row.place.data();
    std::int32_t* __restrict block = row.block[a].data();
    for (std::size_t k = 0; k < count; ++k) {  // two loops: in one, GCC turns `usable` into branches
      const bool usable = (zs[k] > 0) & (middle[k] < kLimit) & (middle[k] > -kLimit);
      place[k] = usable ? middle[k] + direction[k] * along : kOffGrid;
    }
    for (std::size_t k = 0; k < count; ++k) block[k] = floor_to_int(place[k]);
  }
  changed[0] = 1;
  for (std::size_t k = 1; k < count; ++k) {
    changed[k] = ((bx[k] ^ bx[k - 1]) | (by[k] ^ by[k - 1]) | (bz[k] ^ bz[k - 1])) != 0 ? 1 : 0;
  }
}

}  // namespace kernels

namespace {

// Every second pixel is enough to find the blocks as long as they are less than half a block apart: at 2.4 cm and 8 m they are
// 3 cm apart and a block is 38 cm wide. Small voxels seen from afar need every pixel (and still find every block only where
// neighbouring pixels are less than a block apart).
int touch_stride_px(float farthest_m, double focal_px, float block_m) {
  constexpr int kStride_px = 2;
  return kStride_px * farthest_m / static_cast<float>(focal_px) < block_m / 2 ? kStride_px : 1;
}

// Remembers the keys seen last; neighbouring pixels nearly always touch the same blocks.
class RecentKeys {
 public:
  RecentKeys() { keys_.fill(~std::uint64_t{0}); }

  bool seen(std::uint64_t key) {
    std::uint64_t& place = keys_[mixed(key) % keys_.size()];
    if (place == key) return true;
    place = key;
    return false;
  }

 private:
  std::array<std::uint64_t, 256> keys_{};
};

constexpr std::size_t kWord = 8;  // flags looked at together

kernels::TouchRow row_buffers(std::size_t count) {
  kernels::TouchRow row;
  row.count = count;
  row.depth.resize(count);
  row.place.resize(count);
  row.changed.resize((count + kWord - 1) / kWord * kWord, 0);
  for (std::size_t a = 0; a < 3; ++a) {
    row.middle[a].resize(count);
    row.direction[a].resize(count);
    row.block[a].resize(count);
  }
  return row;
}

void collect(const kernels::TouchRow& row, RecentKeys& recent, std::vector<std::uint64_t>& keys) {
  for (std::size_t begin = 0; begin < row.count; begin += kWord) {
    std::uint64_t flags = 0;
    std::memcpy(&flags, row.changed.data() + begin, kWord);
    if (flags == 0) continue;
    for (std::size_t k = begin; k < std::min(begin + kWord, row.count); ++k) {
      const BlockIndex block{row.block[0][k], row.block[1][k], row.block[2][k]};
      const bool nowhere = block.x == kernels::kNowhere || block.y == kernels::kNowhere || block.z == kernels::kNowhere;
      if (row.changed[k] == 0 || nowhere) continue;
      const std::uint64_t key = pack(block);
      if (!recent.seen(key)) keys.push_back(key);
    }
  }
}

// Values that are the same for every row of a frame.
struct BandWalk {
  kernels::RowRays rays{};
  std::vector<float> x;       // of the sampled columns, at depth 1
  std::vector<float> sample;  // distances from the surface, in blocks
  int stride_px = 1;
};

BandWalk band_walk(const FrameView& view, const Band& band, float block_m, float farthest_m) {
  BandWalk walk;
  walk.rays.blocks_per_metre = 1.0F / block_m;
  const Vec3f camera = (view.camera_in_world_m * double{walk.rays.blocks_per_metre}).cast<float>();
  for (int a = 0; a < 3; ++a) {
    walk.rays.per_x[a] = view.world_from_camera(a, 0);
    walk.rays.per_y[a] = view.world_from_camera(a, 1);
    walk.rays.per_z[a] = view.world_from_camera(a, 2);
    walk.rays.origin[a] = camera[a];
  }
  walk.stride_px = touch_stride_px(farthest_m, view.camera.fx, block_m);
  for (int u = 0; u < view.pixels.width; u += walk.stride_px) {
    walk.x.push_back(static_cast<float>((u - view.camera.cx) / view.camera.fx));
  }
  // Samples of the band at steps shorter than a block.
  const float band_blocks = 2 * band.truncation_m * walk.rays.blocks_per_metre;
  const int steps = 1 + static_cast<int>(std::ceil(band_blocks));
  for (int s = 0; s <= steps; ++s) {
    walk.sample.push_back(band_blocks * (static_cast<float>(s) / static_cast<float>(steps) - 0.5F));
  }
  return walk;
}

}  // namespace

void touch_bands(const FrameView& view, const Band& band, float block_m, std::span<std::vector<std::uint64_t>> keys) {
  const BandWalk walk = band_walk(view, band, block_m, view.farthest_m);
  const auto samples = (static_cast<std::size_t>(view.pixels.height) + walk.stride_px - 1) / walk.stride_px;
  parallel_for(keys.size(), [&](std::size_t chunk) {
    RecentKeys recent;
    kernels::TouchRow row = row_buffers(walk.x.size());
    kernels::RowRays rays = walk.rays;
    keys[chunk].clear();
    for (std::size_t sample = samples * chunk / keys.size(); sample < samples * (chunk + 1) / keys.size(); ++sample) {
      const int v = static_cast<int>(sample) * walk.stride_px;
      rays.y = static_cast<float>((v - view.camera.cy) / view.camera.fy);
      const float* depth = view.pixels.depth + view.index(0, v);
      for (std::size_t k = 0; k < row.count; ++k) row.depth[k] = depth[k * static_cast<std::size_t>(walk.stride_px)];
      kernels::cast_row(rays, walk.x.data(), row);
      for (const float along : walk.sample) {
        kernels::sample_row(along, row);
        collect(row, recent, keys[chunk]);
      }
    }
  });
}

}  // namespace panoptic
