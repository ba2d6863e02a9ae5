// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/crf/regularizer.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "panoptic/crf/tiles.h"
#include "panoptic/map/voxel_grid.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

// A tile that would take more memory than this is cut in two, whatever max_blocks says.
constexpr std::size_t kMostBytes = 240'000'000;
// Measured: filters, norms and scratch per voxel, and bits and ranks per block of the box around a tile.
constexpr std::size_t kBytesPerVoxel = 650;
constexpr std::size_t kBytesPerBoxBlock = 4096;
// Tiles above this many blocks, or fewer tiles a thread than that, are solved one after the other on all threads; many small
// ones side by side. The results are the same.
constexpr std::size_t kSmallTile = 64;
constexpr std::size_t kTilesPerThread = 3;

// Holds as many scratches as there are threads at work.
class ScratchPool {
 public:
  std::unique_ptr<MeanFieldScratch> take() {
    const std::lock_guard lock(mutex_);
    if (free_.empty()) return std::make_unique<MeanFieldScratch>();
    auto scratch = std::move(free_.back());
    free_.pop_back();
    return scratch;
  }
  void give_back(std::unique_ptr<MeanFieldScratch> scratch) {
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(scratch));
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<MeanFieldScratch>> free_;
};

// A voxel without any vote takes a label above this probability: three times that of all others together. A message that has come
// far makes a label hardly more probable than the rest.
constexpr float kLittleDoubt = 0.75F;

// The label and weight that a voxel is given if that label is the most probable one; see the header.
VoxelLabel given(const CoreVoxel& voxel, std::uint16_t label, float probability) {
  if (!(voxel.vote_sum > 0)) return probability > kLittleDoubt ? VoxelLabel{label, 0.0F} : VoxelLabel{voxel.voted.label, 0.0F};
  const float most = std::min(voxel.voted.weight, voxel.vote_sum);
  if (label == voxel.voted.label) return {label, most};
  const float observation = voxel.vote_sum * (2 * probability - 1);
  return {label, std::clamp(observation - voxel.voted.weight, 0.0F, std::max(0.0F, most))};
}

bool unchanged(const VoxelBlock& block, const CoreVoxel& before) {
  const Voxel now = block.at(before.voxel);
  return now.label == before.held.label && now.label_weight == before.held.weight && now.weight == before.weight &&
         now.vote_sum == before.vote_sum;
}

std::size_t expected_bytes(const CrfGraph& graph) {
  const GridPoint size = box_around(graph.points).size;
  const auto blocks = [](std::int32_t voxels) { return static_cast<double>(voxels / kBlockSide + 1); };
  const double bytes = blocks(size.x) * blocks(size.y) * blocks(size.z) * kBytesPerBoxBlock +
                       static_cast<double>(graph.size() * (kBytesPerVoxel + (graph.label_count + 7) / 8 * 8 * sizeof(float)));
  return bytes < 1e18 ? static_cast<std::size_t>(bytes) : ~std::size_t{0};
}

void append(TileChanges& to, TileChanges&& from) {
  to.blocks.insert(to.blocks.end(), from.blocks.begin(), from.blocks.end());
  to.changes.insert(to.changes.end(), from.changes.begin(), from.changes.end());
}

}  // namespace

Fields fields(RegularizerOptions& o) {
  return {
      {"enabled", &o.enabled, "regularize the labels of the map with the CRF of section III-G", {}},
      {"every_frames", &o.every_frames, "used frames between two runs; it also runs once at the end", in_range(1, 1e9)},
      {"w1", &o.w1, "weight of the kernel of position and colour", in_range(0, 1000)},
      {"w2", &o.w2, "weight of the kernel of position alone", in_range(0, 1000)},
      {"theta_alpha_m", &o.theta_alpha_m, "width of both kernels in space, metres", in_range(0.001, 0.5)},
      {"theta_beta", &o.theta_beta, "width of the first kernel in colour, of 255", in_range(1, 1000)},
      {"iterations", &o.iterations, "mean-field iterations", in_range(1, 100)},
      {"max_blocks", &o.max_blocks, "blocks of a tile; 0: the whole map at once, as far as memory allows", in_range(0, 1e6)},
      {"band_voxels", &o.band_voxels, "voxels farther than this from the surface are left as they are", in_range(0.5, 32)},
      {"highest_probability", &o.highest_probability, "a voxel's own label is never taken to be more probable than this (Eq. 19)",
       in_range(0.5, 0.999999)},
  };
}

Regularizer::Regularizer(const RegularizerOptions& options, const VoxelMap& map)
    : options_(options), mean_field_{options.w1, options.w2, options.theta_alpha_m / map.voxel_size_m(), options.theta_beta} {
  const auto reach = static_cast<int>(std::ceil(2 * mean_field_.theta_alpha));
  gather_ = {options.band_voxels * map.voxel_size_m(), std::clamp(reach, 1, kBlockSide), options.highest_probability};
}

std::size_t Regularizer::run(VoxelMap& map) {
  const std::vector<std::vector<Slot>> tiles = choose(map);
  std::vector<TileChanges> results(tiles.size());
  ScratchPool pool;
  const auto regularize_one = [&](std::size_t i, Ranges ranges) {
    auto scratch = pool.take();
    results[i] = regularize(map, tiles[i], *scratch, ranges);
    pool.give_back(std::move(scratch));
  };
  const bool small = options_.max_blocks > 0 && static_cast<std::size_t>(options_.max_blocks) <= kSmallTile;
  // Under a memory limit there is memory for one at a time.
  const bool many = tiles.size() >= kTilesPerThread * static_cast<std::size_t>(thread_count());
  if (small && many && map.pager() == nullptr) {
    parallel_for(tiles.size(), [&](std::size_t i) { regularize_one(i, {.parallel = false}); });
  } else {
    for (std::size_t i = 0; i < tiles.size(); ++i) regularize_one(i, {.parallel = true});
  }
  // Only now: all tiles must see their neighbours as they were.
  std::size_t written = 0;
  map.begin_epoch();
  for (const TileChanges& changes : results) written += write_back(changes, map);
  return written;
}

std::vector<std::vector<Slot>> Regularizer::choose(const VoxelMap& map) const {
  std::vector<bool> chosen(map.block_count(), false);
  for (Slot slot = 0; slot < map.block_count(); ++slot) {
    if (map.changed_at(slot) <= (slot < handled_.size() ? handled_[slot] : 0)) continue;
    const BlockIndex c = map.index_of(slot);
    for (int n = 0; n < kNeighbours; ++n) {
      const Slot found = map.find_slot(neighbour(c, n));
      if (found != VoxelMap::kNoSlot) chosen[found] = true;
    }
  }
  std::vector<Slot> slots;
  for (Slot slot = 0; slot < map.block_count(); ++slot) {
    if (chosen[slot]) slots.push_back(slot);
  }
  return divide_into_tiles(map, slots, static_cast<std::size_t>(options_.max_blocks));
}

TileGraph Regularizer::gather(const VoxelMap& map, const std::vector<Slot>& blocks) const {
  return gather_tile(map, votes_, blocks, gather_);
}

TileChanges Regularizer::regularize(const VoxelMap& map, const std::vector<Slot>& blocks, MeanFieldScratch& scratch,
                                    Ranges ranges) const {
  const TileGraph tile = gather(map, blocks);
  if (blocks.size() == 1 || expected_bytes(tile.graph) <= kMostBytes) return solve(tile, scratch, ranges);
  TileChanges all{{}, tile.epoch, {}, tile.next_id};
  for (const std::vector<Slot>& part : divide_into_tiles(map, blocks, (blocks.size() + 1) / 2)) {
    append(all, regularize(map, part, scratch, ranges));
  }
  return all;
}

TileChanges Regularizer::solve(const TileGraph& tile, Ranges ranges) const {
  MeanFieldScratch scratch;
  return solve(tile, scratch, ranges);
}

TileChanges Regularizer::solve(const TileGraph& tile, MeanFieldScratch& scratch, Ranges ranges) const {
  TileChanges result{tile.blocks, tile.epoch, {}, tile.next_id};
  if (tile.core.empty()) return result;
  std::optional<MeanField> field;  // with one label there is nothing to find out
  if (tile.graph.label_count > 1) {
    field.emplace(tile.graph, mean_field_, scratch, ranges);
    for (int i = 0; i < options_.iterations; ++i) field->iterate();
  }
  for (const CoreVoxel& voxel : tile.core) {
    if (tile.graph.labels[voxel.node] == CrfGraph::kOtherLabel) continue;
    const MeanField::Best best = field ? field->best(voxel.node) : MeanField::Best{0, voxel.vote_sum > 0 ? 1.0F : 0.0F};
    const VoxelLabel label = given(voxel, tile.ids[best.label], best.probability);
    if (label.label != voxel.held.label) result.changes.push_back({voxel, label});
  }
  return result;
}

std::vector<bool> Regularizer::named_slots() const {
  std::vector<bool> named(kLabelSlots, false);
  for (const std::vector<OverruledVote>& votes : votes_.all()) {
    for (const OverruledVote& vote : votes) named[vote.voted.label] = named[vote.written.label] = true;
  }
  return named;
}

std::size_t Regularizer::write_back(const TileChanges& changes, VoxelMap& map) {
  handled_.resize(std::max(handled_.size(), map.block_count()), 0);
  // A block that a frame has changed meanwhile stays due, also if it is marked below.
  std::vector<Slot> done;
  std::copy_if(changes.blocks.begin(), changes.blocks.end(), std::back_inserter(done),
               [&](Slot slot) { return map.changed_at(slot) <= changes.epoch; });
  std::size_t written = 0;
  for (const LabelChange& change : changes.changes) {
    VoxelBlock& block = map.block(change.before.slot);
    if (!unchanged(block, change.before)) continue;
    block.set_label(change.before.voxel, change.label.label);
    block.set_label_weight(change.before.voxel, change.label.weight);
    votes_.record(change.before.slot, {change.before.voxel, change.before.voted, change.label});
    map.mark_changed(change.before.slot);
    ++written;
  }
  for (const Slot slot : done) handled_[slot] = map.epoch();
  return written;
}

}  // namespace panoptic
