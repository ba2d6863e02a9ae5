// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/columns.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <unordered_set>

#include "panoptic/map/block_key.h"
#include "panoptic/map/voxel_grid.h"
#include "panoptic/parallel.h"
#include "panoptic/planning/up_frame.h"

namespace panoptic {
namespace {

// Surface at one height of a column.
struct Entry {
  float z_m;
  bool is_floor;
};

// The spots under the square that a sample stands for.
template <typename Visit>
void visit_spots(const GroundGrid& grid, const GroundSample& sample, double sample_m, const Visit& visit) {
  const Eigen::Vector2d at = sample.at_m.head<2>().cast<double>();
  const Eigen::Vector2d half = Eigen::Vector2d::Constant(sample_m / 2);
  const Eigen::Vector2i first = grid.around(at - half);
  const Eigen::Vector2i last = grid.around(at + half);
  for (int y = first.y(); y <= last.y(); ++y) {
    for (int x = first.x(); x <= last.x(); ++x) visit(grid.index({x, y}));
  }
}

GroundGrid grid_around(const std::vector<GroundSample>& samples, double cell_m, double sample_m) {
  GroundGrid grid{cell_m};
  if (samples.empty()) return grid;
  Eigen::Vector2f low = samples.front().at_m.head<2>();
  Eigen::Vector2f high = low;
  for (const GroundSample& sample : samples) {
    low = low.cwiseMin(sample.at_m.head<2>());
    high = high.cwiseMax(sample.at_m.head<2>());
  }
  const Eigen::Vector2d half = Eigen::Vector2d::Constant(sample_m / 2);
  grid.low = grid.around(low.cast<double>() - half) - Eigen::Vector2i::Ones();
  grid.size = grid.around(high.cast<double>() + half) - grid.low + Eigen::Vector2i::Constant(2);
  return grid;
}

// Entries by column, from below: a counting sort.
void sort_entries(const std::vector<GroundSample>& samples, double sample_m, const GroundGrid& grid,
                  std::vector<std::uint32_t>& first, std::vector<Entry>& entries) {
  first.assign(grid.count() + 1, 0);
  for (const GroundSample& sample : samples) {
    visit_spots(grid, sample, sample_m, [&](std::size_t column) { ++first[column + 1]; });
  }
  for (std::size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
  entries.resize(first.back());
  std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
  for (const GroundSample& sample : samples) {
    visit_spots(grid, sample, sample_m, [&](std::size_t column) {
      entries[next[column]++] = {sample.at_m.z(), sample.is_floor};
    });
  }
  parallel_for(static_cast<std::size_t>(grid.size.y()), [&](std::size_t row) {
    const auto width = static_cast<std::size_t>(grid.size.x());
    for (std::size_t column = row * width; column < (row + 1) * width; ++column) {
      std::sort(entries.begin() + first[column], entries.begin() + first[column + 1],
                [](const Entry& a, const Entry& b) { return a.z_m < b.z_m || (a.z_m == b.z_m && !a.is_floor && b.is_floor); });
    }
  });
}

// The spans of one column.
void add_spans(std::span<const Entry> entries, float gap_m, float climb_m, std::vector<SolidSpan>& spans) {
  std::size_t i = 0;
  while (i < entries.size()) {
    SolidSpan span{entries[i].z_m, entries[i].z_m};
    float floor_m = -std::numeric_limits<float>::infinity();
    for (; i < entries.size() && entries[i].z_m - span.top_m <= gap_m; ++i) {
      span.top_m = entries[i].z_m;
      if (entries[i].is_floor) floor_m = entries[i].z_m;
    }
    span.is_floor = span.top_m - floor_m <= climb_m;
    spans.push_back(span);
  }
}

// Cells are counted like blocks, so they have the same keys and neighbours.
using Cell = BlockIndex;

Cell cell_of(const GroundSample& sample, double cell_m) {
  const Eigen::Vector3i at = (sample.at_m.cast<double>() / cell_m).array().floor().matrix().cast<int>();
  return {at.x(), at.y(), at.z()};
}

// Cells with surface by key, and the number of the piece that each belongs to.
using Pieces = std::unordered_map<std::uint64_t, std::uint32_t>;
constexpr std::uint32_t kNoPiece = ~std::uint32_t{0};

// Gives a cell and all that hangs together with it the number; returns the length of the box around it, in cells.
int flood_piece(Pieces& pieces, const Cell& from, std::uint32_t number) {
  Eigen::AlignedBox3i box;
  std::vector<Cell> waiting = {from};
  pieces[pack(from)] = number;
  while (!waiting.empty()) {
    const Cell cell = waiting.back();
    waiting.pop_back();
    box.extend(Eigen::Vector3i(cell.x, cell.y, cell.z));
    for (int n = 0; n < kNeighbours; ++n) {
      const Cell next = neighbour(cell, n);
      const auto found = pieces.find(pack(next));
      if (found == pieces.end() || found->second != kNoPiece) continue;
      found->second = number;
      waiting.push_back(next);
    }
  }
  return box.sizes().maxCoeff() + 1;
}

// Drops surface that hangs in the air and is no longer than a hand: the sensor's noise. Real things stand on or hang from others.
void drop_specks(std::vector<GroundSample>& samples, double cell_m) {
  constexpr double kHand_m = 0.2;
  Pieces pieces;
  for (const GroundSample& sample : samples) pieces.emplace(pack(cell_of(sample, cell_m)), kNoPiece);
  std::vector<char> is_speck;
  for (const GroundSample& sample : samples) {
    if (pieces.at(pack(cell_of(sample, cell_m))) != kNoPiece) continue;
    const int length = flood_piece(pieces, cell_of(sample, cell_m), static_cast<std::uint32_t>(is_speck.size()));
    is_speck.push_back(length * cell_m <= kHand_m ? 1 : 0);
  }
  std::erase_if(samples, [&](const GroundSample& s) { return is_speck[pieces.at(pack(cell_of(s, cell_m)))] != 0; });
}

constexpr double kSquare_m = 1;

std::uint64_t square_of(const GroundSample& sample) {
  const Cell cell = cell_of(sample, kSquare_m);
  return pack(Cell{cell.x, cell.y, 0});
}

// The least weight of well seen surface, by square.
std::unordered_map<std::uint64_t, float> least_weights(const std::vector<GroundSample>& samples) {
  constexpr double kUsual = 0.8;  // the rank of the weight that the others are held against
  constexpr float kShare = 0.25F;
  std::unordered_map<std::uint64_t, std::vector<float>> weights_in;
  for (const GroundSample& sample : samples) weights_in[square_of(sample)].push_back(sample.weight);
  std::unordered_map<std::uint64_t, float> least_in;
  for (auto& [square, weights] : weights_in) {
    const auto usual = weights.begin() + static_cast<std::ptrdiff_t>(kUsual * static_cast<double>(weights.size() - 1));
    std::nth_element(weights.begin(), usual, weights.end());
    least_in[square] = kShare * *usual;
  }
  return least_in;
}

// Drops surface that was hardly seen in comparison with the rest of its square metre: what stands there is seen about as often,
// and from as near, as the floor around it. Sensors see things in the air at the rims of others, each time elsewhere, and crumbs
// on the floor, which are a step too high for the agent: floor goes only if there is other floor right below it. Beside
// well seen obstacles (in the next cell) all stays: rims of things are seen less than their middles. The limits are not critical:
// see docs/planning.md.
void drop_hardly_seen(std::vector<GroundSample>& samples, double cell_m) {
  const auto least_in = least_weights(samples);
  const auto is_well_seen = [&](const GroundSample& s) { return s.weight >= least_in.at(square_of(s)); };
  std::unordered_set<std::uint64_t> well_seen;
  std::unordered_set<std::uint64_t> floor;
  for (const GroundSample& sample : samples) {
    if (sample.is_floor) {
      floor.insert(pack(cell_of(sample, cell_m)));
    } else if (is_well_seen(sample)) {
      well_seen.insert(pack(cell_of(sample, cell_m)));
    }
  }
  const auto lies_on_floor = [&](const Cell& cell) {
    constexpr double kCrumb_m = 0.1;
    const int most = static_cast<int>(kCrumb_m / cell_m);
    for (int below = 1; below <= most; ++below) {
      if (floor.contains(pack(Cell{cell.x, cell.y, cell.z - below}))) return true;
    }
    return false;
  };
  const auto is_beside = [&](const Cell& cell) {
    for (int n = 0; n < kNeighbours; ++n) {
      if (well_seen.contains(pack(neighbour(cell, n)))) return true;
    }
    return well_seen.contains(pack(cell));
  };
  std::vector<char> is_noise(samples.size());
  std::vector<bool> stays(kLabelSlots, false);  // no object goes whole: networks saw it
  stays[number(LabelSlot::kUnknown)] = true;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const GroundSample& s = samples[i];
    const Cell cell = cell_of(s, cell_m);
    is_noise[i] = !is_well_seen(s) && !is_beside(cell) && (!s.is_floor || lies_on_floor(cell)) ? 1 : 0;
    if (is_noise[i] == 0) stays[number(s.label)] = true;
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (is_noise[i] == 0 || !stays[number(samples[i].label)]) samples[kept++] = samples[i];
  }
  samples.resize(kept);
}

}  // namespace

SolidColumns solid_columns(const std::vector<GroundSample>& samples, double cell_m, double sample_m, double climb_m) {
  SolidColumns columns;
  columns.grid = grid_around(samples, cell_m, sample_m);
  std::vector<std::uint32_t> first;
  std::vector<Entry> entries;
  sort_entries(samples, sample_m, columns.grid, first, entries);
  columns.first.reserve(first.size());
  columns.first.push_back(0);
  const auto gap_m = static_cast<float>(2 * sample_m);
  for (std::size_t column = 0; column < columns.grid.count(); ++column) {
    add_spans(std::span(entries).subspan(first[column], first[column + 1] - first[column]), gap_m, static_cast<float>(climb_m),
              columns.spans);
    columns.first.push_back(static_cast<std::uint32_t>(columns.spans.size()));
  }
  return columns;
}

std::vector<GroundSample> ground_samples(const PanopticMap& map, const UpFrame& frame, const SurfaceByBlock& surface,
                                         double climb_m) {
  const Eigen::Isometry3f grid_from_world = frame.grid_from_world.cast<float>();
  std::vector<bool> floor_label(kLabelSlots, false);
  for (std::size_t n = 0; n < kLabelSlots; ++n) {
    floor_label[n] = is_floor_class(map.labels, map.class_of(static_cast<LabelSlot>(n)));
  }
  std::vector<std::vector<GroundSample>> by_block(surface.size());
  parallel_for(surface.size(), [&](std::size_t slot) {
    for (const SurfaceSample& sample : surface[slot]) {
      const Vec3f at_m = grid_from_world * sample.at_m;
      const float up = (grid_from_world.linear() * sample.normal).z();
      const bool is_floor = std::abs(at_m.z()) <= climb_m || (up > kLevelCosine && floor_label[number(sample.label)]);
      by_block[slot].push_back({at_m, is_floor, up < -kLevelCosine, sample.label, sample.weight});
    }
  });
  std::vector<GroundSample> samples;
  for (const auto& block : by_block) samples.insert(samples.end(), block.begin(), block.end());
  drop_hardly_seen(samples, double{map.voxels.voxel_size_m()});
  drop_specks(samples, 2 * double{map.voxels.voxel_size_m()});
  return samples;
}

}  // namespace panoptic
