// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/crf/tile_graph.h"

#include <algorithm>
#include <bit>
#include <map>

#include "panoptic/map/block_key.h"
#include "panoptic/map/voxel_grid.h"

namespace panoptic {
namespace {

constexpr int kSide = kBlockSide;

// A block's voxels that belong to the graph.
struct Part {
  BlockIndex index;
  Slot slot = VoxelMap::kNoSlot;
  bool core = false;
  BlockBits rows{};
};

struct Span1 {
  int begin;
  int end;
};

// Along one axis: the voxels of a neighbour at that offset (-1, 0, 1) which are within reach.
Span1 reached(int offset, int reach) {
  if (offset < 0) return {kSide - reach, kSide};
  return {0, offset == 0 ? kSide : reach};
}

void add_box(Part& part, Span1 x, Span1 y, Span1 z) {
  const auto bits = static_cast<std::uint16_t>(((1U << x.end) - 1U) & ~((1U << x.begin) - 1U));
  for (int k = z.begin; k < z.end; ++k) {
    for (int j = y.begin; j < y.end; ++j) part.rows[static_cast<std::size_t>(j + kSide * k)] |= bits;
  }
}

// The tile's blocks whole, their neighbours as far as the halo reaches; in the order of their keys, which is (z, y, x).
std::vector<Part> parts_of(const VoxelMap& map, std::span<const Slot> blocks, const GatherSettings& settings) {
  std::map<std::uint64_t, Part> parts;
  for (const Slot slot : blocks) {
    const BlockIndex c = map.index_of(slot);
    for (int n = 0; n < kNeighbours; ++n) {
      const BlockIndex step = step_to(n);
      const BlockIndex index = neighbour(c, n);
      const Slot found = map.find_slot(index);
      if (found == VoxelMap::kNoSlot) continue;
      Part& part = parts[pack(index)];
      part.index = index;
      part.slot = found;
      part.core |= found == slot;
      const auto halo = [&](std::int32_t along) { return reached(along, settings.halo_voxels); };
      add_box(part, halo(step.x), halo(step.y), halo(step.z));
    }
  }
  std::vector<Part> sorted;
  sorted.reserve(parts.size());
  for (auto& [key, part] : parts) {
    const BlockBits surface = surface_bits(map.block(part.slot), settings.band_m);
    for (std::size_t row = 0; row < surface.size(); ++row) part.rows[row] &= surface[row];
    sorted.push_back(part);
  }
  return sorted;
}

// Copies voxels into the graph. Labels are panoptic ids for now.
class Copier {
 public:
  Copier(const VoxelMap& map, const FrameVotes& votes, float highest_probability, TileGraph& out)
      : map_(map), votes_(votes), highest_probability_(highest_probability), out_(out) {}

  // Parts of one layer of blocks along z, so that nodes come out in the order of (z, y, x).
  void copy_layer(std::span<const Part> parts) {
    for (int z = 0; z < kSide; ++z) {
      for (auto first = parts.begin(); first != parts.end();) {
        const auto past = std::find_if(first, parts.end(), [&](const Part& p) { return p.index.y != first->index.y; });
        for (int y = 0; y < kSide; ++y) {
          for (auto part = first; part != past; ++part) copy_row(*part, y, z);
        }
        first = past;
      }
    }
  }

 private:
  void copy_row(const Part& part, int y, int z) {
    const VoxelBlock& block = map_.block(part.slot);
    for (std::uint32_t bits = part.rows[static_cast<std::size_t>(y + kSide * z)]; bits != 0; bits &= bits - 1) {
      const int x = std::countr_zero(bits);
      add_node(part, block, voxel_offset(x, y, z),
               {part.index.x * kSide + x, part.index.y * kSide + y, part.index.z * kSide + z});
    }
  }

  void add_node(const Part& part, const VoxelBlock& block, int offset, GridPoint point) {
    CrfGraph& g = out_.graph;
    const Voxel voxel = block.at(offset);
    const VoxelLabel held{voxel.label, voxel.label_weight};
    const VoxelLabel voted = votes_.voted(part.slot, static_cast<std::uint16_t>(offset), held);
    if (part.core) {
      out_.core.push_back({static_cast<std::uint32_t>(g.size()), part.slot, static_cast<std::uint16_t>(offset), held, voted,
                           voxel.weight, voxel.vote_sum});
    }
    g.points.push_back(point);
    const auto channel = [&](std::uint16_t value) { return static_cast<float>(value) / 256.0F; };
    g.colors.push_back({channel(voxel.red), channel(voxel.green), channel(voxel.blue)});
    g.labels.push_back(voxel.vote_sum > 0 ? voted.label : CrfGraph::kNoLabel);
    const float p = 0.5F * (1.0F + label_share(voted.weight, voxel.vote_sum));  // Eq. 19
    g.probabilities.push_back(p > 0.5F ? std::min(p, highest_probability_) : 0.5F);
  }

  const VoxelMap& map_;
  const FrameVotes& votes_;
  float highest_probability_;
  TileGraph& out_;
};

// Renumbers the labels 0, 1, 2 ... in their order.
void number_labels(TileGraph& tile) {
  std::vector<std::uint32_t> counts(65536, 0);
  for (const std::uint16_t id : tile.graph.labels) counts[id == CrfGraph::kNoLabel ? number(LabelSlot::kUnknown) : id]++;
  for (std::size_t id = 0; id < counts.size(); ++id) {
    if (counts[id] > 0) tile.ids.push_back(static_cast<std::uint16_t>(id));
  }
  tile.graph.all_labels = tile.ids.size();
  if (tile.ids.size() > kMostLabels) {
    std::stable_sort(tile.ids.begin(), tile.ids.end(), [&](std::uint16_t a, std::uint16_t b) { return counts[a] > counts[b]; });
    tile.ids.resize(kMostLabels);
    std::sort(tile.ids.begin(), tile.ids.end());
  }
  tile.graph.label_count = tile.ids.size();
  std::vector<std::uint16_t> label_of(65536, CrfGraph::kOtherLabel);
  label_of[CrfGraph::kNoLabel] = CrfGraph::kNoLabel;
  for (std::size_t l = 0; l < tile.ids.size(); ++l) label_of[tile.ids[l]] = static_cast<std::uint16_t>(l);
  for (std::uint16_t& label : tile.graph.labels) label = label_of[label];
}

}  // namespace

TileGraph gather_tile(const VoxelMap& map, const FrameVotes& votes, std::span<const Slot> blocks,
                      const GatherSettings& settings) {
  TileGraph out;
  out.blocks.assign(blocks.begin(), blocks.end());
  out.epoch = map.epoch();
  const std::vector<Part> parts = parts_of(map, blocks, settings);
  Copier copier(map, votes, settings.highest_probability, out);
  for (auto first = parts.begin(); first != parts.end();) {
    const auto past = std::find_if(first, parts.end(), [&](const Part& p) { return p.index.z != first->index.z; });
    copier.copy_layer({first, past});
    first = past;
  }
  number_labels(out);
  return out;
}

}  // namespace panoptic
