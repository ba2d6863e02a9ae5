// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/crf/label_columns.h"

#include <algorithm>
#include <numeric>

#include "panoptic/base/lanes.h"

namespace panoptic {
namespace {

using TileSet = std::vector<std::uint64_t>;

std::size_t groups_of(std::size_t columns) { return (columns + kLanes - 1) / kLanes; }

// Points that follow each other in one tile.
struct Run {
  GridPoint tile;
  std::size_t end;
};

std::vector<Run> runs_of(std::span<const GridPoint> points, std::int32_t side) {
  std::vector<Run> runs;
  GridPoint at{0, 0, 0};
  std::int64_t past_x = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const GridPoint& p = points[i];
    if (i == 0 || p.x >= past_x || p.y != at.y || p.z != at.z) {
      runs.push_back({cell_of(p, side), i});
      past_x = (std::int64_t{runs.back().tile.x} + 1) * side;
      at = p;
    }
    runs.back().end = i + 1;
  }
  return runs;
}

BitGrid tiles_of(std::span<const Run> runs) {
  std::vector<GridPoint> tiles;
  tiles.reserve(runs.size());
  for (const Run& run : runs) tiles.push_back(run.tile);
  const GridBox box = box_around(tiles);
  BitGrid grid(box);
  for (const GridPoint& t : tiles) grid.set({t.x - box.origin.x, t.y - box.origin.y, t.z - box.origin.z});
  grid.number_points();
  return grid;
}

// body(tile) for the numbers of the tiles around a tile, itself included.
template <typename Body>
void for_each_around(const BitGrid& tiles, GridPoint t, const Body& body) {
  const GridPoint size = tiles.box().size;
  for (std::int32_t z = std::max(0, t.z - 1); z <= std::min(size.z - 1, t.z + 1); ++z) {
    for (std::int32_t y = std::max(0, t.y - 1); y <= std::min(size.y - 1, t.y + 1); ++y) {
      for (std::int32_t x = std::max(0, t.x - 1); x <= std::min(size.x - 1, t.x + 1); ++x) {
        if (tiles.contains({x, y, z})) body(tiles.rank({x, y, z}));
      }
    }
  }
}

void add(TileSet& set, std::size_t tile) { set[tile / 64] |= std::uint64_t{1} << (tile % 64); }
bool holds(const TileSet& set, std::size_t tile) { return (set[tile / 64] >> (tile % 64) & 1U) != 0; }

bool apart(const TileSet& a, const TileSet& b) {
  for (std::size_t w = 0; w < a.size(); ++w) {
    if ((a[w] & b[w]) != 0) return false;
  }
  return true;
}

std::size_t size_of(const TileSet& set) {
  return std::accumulate(set.begin(), set.end(), std::size_t{0},
                         [](std::size_t n, std::uint64_t w) { return n + count_bits(w); });
}

// For every label, the tiles around those that hold its voxels.
std::vector<TileSet> find_regions(std::span<const Run> runs, std::span<const std::uint16_t> labels, const BitGrid& tiles,
                                  std::size_t label_count) {
  const GridPoint origin = tiles.box().origin;
  const GridPoint size = tiles.box().size;
  const std::size_t words = tiles.rank({size.x - 1, size.y - 1, size.z - 1}) / 64 + 1;
  std::vector<TileSet> held(label_count, TileSet(words, 0));
  std::vector<TileSet> regions = held;
  std::size_t i = 0;
  for (const Run& run : runs) {
    const GridPoint t{run.tile.x - origin.x, run.tile.y - origin.y, run.tile.z - origin.z};
    const std::uint32_t tile = tiles.rank(t);
    for (; i < run.end; ++i) {
      const std::uint16_t label = labels[i];
      if (label >= label_count || holds(held[label], tile)) continue;
      add(held[label], tile);
      for_each_around(tiles, t, [&](std::size_t near) { add(regions[label], near); });
    }
  }
  return regions;
}

}  // namespace

LabelColumns::LabelColumns(std::span<const GridPoint> points, std::span<const std::uint16_t> labels, std::size_t label_count,
                           std::int32_t reach)
    : side_(reach), tiles_({{0, 0, 0}, {1, 1, 1}}), column_of_(label_count), labels_(label_count) {
  std::iota(column_of_.begin(), column_of_.end(), std::uint16_t{0});
  for (std::size_t label = 0; label < label_count; ++label) labels_[label] = {static_cast<std::uint16_t>(label)};
  if (groups_of(label_count) <= 1) return;
  const std::vector<Run> runs = runs_of(points, reach);
  tiles_ = tiles_of(runs);
  share(find_regions(runs, labels, tiles_, label_count));
}

// Label by label, those that reach farthest first, into the first column where there is room.
void LabelColumns::share(std::vector<TileSet> regions) {
  std::vector<std::size_t> sizes(regions.size());
  std::transform(regions.begin(), regions.end(), sizes.begin(), size_of);
  std::vector<std::uint16_t> order = column_of_;
  std::stable_sort(order.begin(), order.end(), [&](std::uint16_t a, std::uint16_t b) { return sizes[a] > sizes[b]; });
  std::vector<TileSet> taken;
  std::vector<std::vector<std::uint16_t>> labels;
  std::vector<std::uint16_t> column_of(regions.size());
  for (const std::uint16_t label : order) {
    const TileSet& region = regions[label];
    const auto room = std::find_if(taken.begin(), taken.end(), [&](const TileSet& set) { return apart(set, region); });
    const auto column = static_cast<std::size_t>(room - taken.begin());
    if (room == taken.end()) {
      taken.emplace_back(region.size(), 0);
      labels.emplace_back();
    }
    for (std::size_t w = 0; w < region.size(); ++w) taken[column][w] |= region[w];
    labels[column].push_back(label);
    column_of[label] = static_cast<std::uint16_t>(column);
  }
  if (groups_of(labels.size()) >= groups_of(regions.size())) return;
  column_of_ = std::move(column_of);
  labels_ = std::move(labels);
  regions_ = std::move(regions);
}

std::uint16_t LabelColumns::label_at(std::size_t column, GridPoint point) const {
  const std::vector<std::uint16_t>& labels = labels_[column];
  if (labels.size() == 1) return labels[0];
  const GridPoint o = tiles_.box().origin;
  const GridPoint at = cell_of(point, side_);
  const std::uint32_t tile = tiles_.rank({at.x - o.x, at.y - o.y, at.z - o.z});
  const auto found =
      std::find_if(labels.begin(), labels.end(), [&](std::uint16_t label) { return holds(regions_[label], tile); });
  return found == labels.end() ? labels[0] : *found;
}

}  // namespace panoptic
