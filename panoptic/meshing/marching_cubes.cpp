// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <functional>

#include "panoptic/meshing/marching_cubes_table.h"
#include "panoptic/meshing/mesher.h"

namespace panoptic {
namespace {

constexpr int kSide = kBlockSide + 1;  // corners per axis: the block's voxels and the first of the next block

// The block and its seven neighbours towards higher coordinates, where the corners of its cells lie.
class Neighbourhood {
 public:
  Neighbourhood(const VoxelMap& map, BlockIndex index) {
    for (int n = 0; n < 8; ++n) {
      blocks_[static_cast<std::size_t>(n)] = map.find({index.x + (n & 1), index.y + (n >> 1 & 1), index.z + (n >> 2 & 1)});
    }
  }

  // Number n is one block farther along x, y and z where bits 0, 1 and 2 are set; nullptr if it does not exist.
  const VoxelBlock* block(int n) const { return blocks_[static_cast<std::size_t>(n)]; }
  // The voxel of a corner, each coordinate 0..16. REQUIRES that its block exists.
  Voxel voxel(const std::array<int, 3>& corner) const {
    return block(corner[0] >> 4 | (corner[1] >> 4) << 1 | (corner[2] >> 4) << 2)
        ->at(voxel_offset(corner[0] & 15, corner[1] & 15, corner[2] & 15));
  }

 private:
  std::array<const VoxelBlock*, 8> blocks_{};
};

// Per row of corners along x, one bit per corner: was it observed, is it inside. Whole rows of cells are then decided at once.
struct CornerBits {
  std::array<std::uint32_t, kSide * kSide> observed{};
  std::array<std::uint32_t, kSide * kSide> inside{};
};

// Adds the voxels of a brick of neighbour n, as far as corners lie there.
void add_corners(const Brick& brick, int number, int n, float min_weight, CornerBits& bits) {
  const float* weight = brick.plane(FloatPlane::kWeight);
  const float* distance = brick.plane(FloatPlane::kDistance);
  int i = 0;
  for (std::uint64_t rest = brick.stored(); rest != 0; rest &= rest - 1, ++i) {
    const int offset = offset_in_block(number, std::countr_zero(rest));
    const int x = offset % kBlockSide + (n & 1) * kBlockSide;
    const int y = offset / kBlockSide % kBlockSide + (n >> 1 & 1) * kBlockSide;
    const int z = offset / (kBlockSide * kBlockSide) + (n >> 2) * kBlockSide;
    if (x >= kSide || y >= kSide || z >= kSide) continue;
    const auto row = static_cast<std::size_t>(y + kSide * z);
    bits.observed[row] |= static_cast<std::uint32_t>(weight[i] > min_weight) << x;
    bits.inside[row] |= static_cast<std::uint32_t>(distance[i] < 0) << x;
  }
}

CornerBits corner_bits(const Neighbourhood& blocks, float min_weight) {
  CornerBits bits;
  for (int n = 0; n < 8; ++n) {
    const VoxelBlock* block = blocks.block(n);
    if (block == nullptr) continue;
    const int first_only = spread(3 * (n & 1) | 12 * (n >> 1 & 1) | 48 * (n >> 2));  // on the axes of the step
    for (int number = 0; number < kBlockBricks; ++number) {
      if ((spread(number) & first_only) == 0) add_corners(block->brick(number), number, n, min_weight, bits);
    }
  }
  return bits;
}

// Grows one chunk; remembers which grid edges already have their vertex.
class ChunkBuilder {
 public:
  ChunkBuilder(const VoxelMap& map, const ObjectRegistry& objects, Slot slot)
      : blocks_(map, map.index_of(slot)), objects_(objects), voxel_size_m_(map.voxel_size_m()) {
    const BlockIndex index = map.index_of(slot);
    origin_ = Vec3d(index.x, index.y, index.z) * kBlockSide;
    vertex_of_edge_.fill(kNoVertex);
  }

  void add_cell(int x, int y, int z, unsigned pattern) {
    for (const CellTriangle& triangle : cell_triangles()[pattern]) {
      const std::array<std::uint32_t, 3> t = {vertex(x, y, z, triangle[0]), vertex(x, y, z, triangle[1]),
                                              vertex(x, y, z, triangle[2])};
      const Vec3f& a = chunk_.vertices[t[0]].position;
      const Vec3f normal = (chunk_.vertices[t[1]].position - a).cross(chunk_.vertices[t[2]].position - a);
      for (const std::uint32_t v : t) chunk_.vertices[v].area_normal += normal;
      chunk_.triangles.push_back(t);
    }
  }

  const Neighbourhood& blocks() const { return blocks_; }
  MeshChunk take() { return std::move(chunk_); }

 private:
  static constexpr std::uint16_t kNoVertex = 65535;

  std::uint32_t vertex(int x, int y, int z, std::uint8_t edge) {
    const auto [corner, axis] = kCellEdges[edge];
    const int cx = x + (corner & 1);
    const int cy = y + (corner >> 1 & 1);
    const int cz = z + (corner >> 2 & 1);
    std::uint16_t& known = vertex_of_edge_[static_cast<std::size_t>((cx + kSide * (cy + kSide * cz)) * 3 + axis)];
    if (known == kNoVertex) {
      known = static_cast<std::uint16_t>(chunk_.vertices.size());
      add_vertex({cx, cy, cz}, axis);
    }
    return known;
  }

  void add_vertex(const std::array<int, 3>& lower, std::uint8_t axis) {
    std::array<int, 3> upper = lower;
    upper[axis] += 1;
    const Voxel a = blocks_.voxel(lower);
    const Voxel b = blocks_.voxel(upper);
    const float along = a.distance / (a.distance - b.distance);
    Vec3d place = origin_ + Vec3d(lower[0], lower[1], lower[2]) + Vec3d::Constant(0.5);
    place[axis] += double{along};
    ChunkVertex v{};
    v.position = (place * double{voxel_size_m_}).cast<float>();
    v.area_normal = Vec3f::Zero();
    v.color = {mixed_channel(a.red, b.red, along), mixed_channel(a.green, b.green, along), mixed_channel(a.blue, b.blue, along)};
    const Voxel& nearer = along < 0.5F ? a : b;
    v.panoptic_id = objects_.id_of(static_cast<LabelSlot>(nearer.label));
    v.weight = std::min(a.weight, b.weight);
    v.confidence = static_cast<std::uint8_t>(std::lround(label_share(nearer.label_weight, nearer.vote_sum) * 255.0F));
    v.corner_x = static_cast<std::uint8_t>(lower[0]);
    v.corner_y = static_cast<std::uint8_t>(lower[1]);
    v.corner_z = static_cast<std::uint8_t>(lower[2]);
    v.axis = axis;
    chunk_.vertices.push_back(v);
  }

  // 8.8 fixed point; 0 = that voxel has no colour yet, so the other one decides.
  static std::uint8_t mixed_channel(std::uint16_t a, std::uint16_t b, float along) {
    if (a == 0) return static_cast<std::uint8_t>(b >> 8);
    if (b == 0) return static_cast<std::uint8_t>(a >> 8);
    const float value = static_cast<float>(a) + (static_cast<float>(b) - static_cast<float>(a)) * along;
    return static_cast<std::uint8_t>(value / 256.0F);
  }

  Neighbourhood blocks_;
  const ObjectRegistry& objects_;
  Vec3d origin_;  // voxels
  float voxel_size_m_;
  MeshChunk chunk_;
  std::array<std::uint16_t, kSide * kSide * kSide * 3> vertex_of_edge_{};
};

unsigned cell_pattern(const CornerBits& bits, std::size_t row, int x) {
  unsigned pattern = 0;
  pattern |= bits.inside[row] >> x & 3U;
  pattern |= (bits.inside[row + 1] >> x & 3U) << 2;
  pattern |= (bits.inside[row + kSide] >> x & 3U) << 4;
  pattern |= (bits.inside[row + kSide + 1] >> x & 3U) << 6;
  return pattern;
}

}  // namespace

MeshChunk extract_chunk(const VoxelMap& map, const ObjectRegistry& objects, Slot slot, float min_weight) {
  ChunkBuilder builder(map, objects, slot);
  const CornerBits bits = corner_bits(builder.blocks(), min_weight);
  for (int z = 0; z < kBlockSide; ++z) {
    for (int y = 0; y < kBlockSide; ++y) {
      const auto row = static_cast<std::size_t>(y + kSide * z);
      const auto of_four = [&](const auto& plane, auto combine) {
        const std::uint32_t rows =
            combine(combine(plane[row], plane[row + 1]), combine(plane[row + kSide], plane[row + kSide + 1]));
        return combine(rows, rows >> 1);
      };
      const std::uint32_t observed = of_four(bits.observed, std::bit_and<>());
      const std::uint32_t some_inside = of_four(bits.inside, std::bit_or<>());
      const std::uint32_t all_inside = of_four(bits.inside, std::bit_and<>());
      std::uint32_t cells = observed & some_inside & ~all_inside & 0xFFFFU;
      for (; cells != 0; cells &= cells - 1) {
        const int x = std::countr_zero(cells);
        builder.add_cell(x, y, z, cell_pattern(bits, row, x));
      }
    }
  }
  return builder.take();
}

}  // namespace panoptic
