// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
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

  // The block that holds corner (x, y, z), each 0..16; nullptr if it does not exist.
  const VoxelBlock* block(int x, int y, int z) const {
    return blocks_[static_cast<std::size_t>((x >> 4) | (y >> 4) << 1 | (z >> 4) << 2)];
  }
  static std::size_t offset(int x, int y, int z) { return static_cast<std::size_t>(voxel_offset(x & 15, y & 15, z & 15)); }

 private:
  std::array<const VoxelBlock*, 8> blocks_{};
};

// Per row of corners along x, one bit per corner: was it observed, is it inside. Whole rows of cells are then decided at once.
struct CornerBits {
  std::array<std::uint32_t, kSide * kSide> observed{};
  std::array<std::uint32_t, kSide * kSide> inside{};
};

CornerBits corner_bits(const Neighbourhood& blocks, float min_weight) {
  CornerBits bits;
  for (int z = 0; z < kSide; ++z) {
    for (int y = 0; y < kSide; ++y) {
      std::uint32_t observed = 0;
      std::uint32_t inside = 0;
      for (int x = 0; x < kSide; ++x) {
        const VoxelBlock* block = blocks.block(x, y, z);
        if (block == nullptr) continue;
        const std::size_t voxel = Neighbourhood::offset(x, y, z);
        observed |= static_cast<std::uint32_t>(block->weight[voxel] > min_weight) << x;
        inside |= static_cast<std::uint32_t>(block->distance[voxel] < 0) << x;
      }
      bits.observed[static_cast<std::size_t>(y + kSide * z)] = observed;
      bits.inside[static_cast<std::size_t>(y + kSide * z)] = inside;
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
    const VoxelBlock& a = *blocks_.block(lower[0], lower[1], lower[2]);
    const VoxelBlock& b = *blocks_.block(upper[0], upper[1], upper[2]);
    const std::size_t i = Neighbourhood::offset(lower[0], lower[1], lower[2]);
    const std::size_t j = Neighbourhood::offset(upper[0], upper[1], upper[2]);
    const float along = a.distance[i] / (a.distance[i] - b.distance[j]);
    Vec3d place = origin_ + Vec3d(lower[0], lower[1], lower[2]) + Vec3d::Constant(0.5);
    place[axis] += double{along};
    ChunkVertex v{};
    v.position = (place * double{voxel_size_m_}).cast<float>();
    v.area_normal = Vec3f::Zero();
    v.color = {mixed_channel(a.red[i], b.red[j], along), mixed_channel(a.green[i], b.green[j], along),
               mixed_channel(a.blue[i], b.blue[j], along)};
    const bool lower_is_nearer = along < 0.5F;
    v.panoptic_id = objects_.id_of(static_cast<LabelSlot>(lower_is_nearer ? a.label[i] : b.label[j]));
    v.confidence = lower_is_nearer ? confidence(a, i) : confidence(b, j);
    v.corner_x = static_cast<std::uint8_t>(lower[0]);
    v.corner_y = static_cast<std::uint8_t>(lower[1]);
    v.corner_z = static_cast<std::uint8_t>(lower[2]);
    v.axis = axis;
    chunk_.vertices.push_back(v);
  }

  static std::uint8_t confidence(const VoxelBlock& block, std::size_t voxel) {
    return static_cast<std::uint8_t>(std::lround(label_share(block.label_weight[voxel], block.vote_sum[voxel]) * 255.0F));
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
