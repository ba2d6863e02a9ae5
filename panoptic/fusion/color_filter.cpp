// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/color_filter.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "panoptic/base/clones.h"
#include "panoptic/fusion/fast_exp.h"
#include "panoptic/fusion/lanes.h"

namespace panoptic {
namespace {

// Pairs whose weight is below e^-kFarthest are left out.
constexpr float kFarthest = 5.0F;
// A voxel joins a cluster whose first voxel's colour is nearer than this share of theta_beta.
constexpr float kSameColor = 1.0F;

std::int32_t floor_divide(std::int32_t a, std::int32_t b) { return a / b - (a % b < 0 ? 1 : 0); }

float squared_difference(const VoxelColor& a, const VoxelColor& b) {
  return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]);
}

std::vector<GridPoint> cells_of(std::span<const GridPoint> points, std::int32_t side) {
  std::vector<GridPoint> cells;
  cells.reserve(points.size());
  for (const GridPoint& p : points) {
    cells.push_back({floor_divide(p.x, side), floor_divide(p.y, side), floor_divide(p.z, side)});
  }
  return cells;
}

}  // namespace

// The clusters' mean positions and colours, each scaled so that a pair's weight is e^-(squared difference). One plane per
// coordinate; the clusters of a cell follow each other, cells in the order of (z, y, x).
struct ColorFilter::Centers {
  explicit Centers(const GridBox& box) : cells(box) {}

  BitGrid cells;
  std::vector<GridPoint> cell_of;          // by cluster, within the box
  std::vector<std::uint32_t> first_of;     // by cell, and one more at the end
  std::array<std::vector<float>, 6> axes;  // x y z red green blue
};

// Clusters that follow each other: those of some cells of a row.
struct ClusterRange {
  std::uint32_t first;
  std::uint32_t past;
};

// External linkage on purpose: GCC's target_clones need it.
namespace kernels {

struct PairWork {
  std::array<const float*, 6> axes;  // of all clusters, and eight values more
  std::size_t cluster;
  std::span<const ClusterRange> candidates;
  float least;           // weights up to this are left out
  std::uint32_t* found;  // two numbers per pair, the cluster and the bits of the weight; room for all candidates and eight more
};

// Returns how many pairs were found.
std::size_t find_pairs(const PairWork& work);
void sum_pairs_8(const std::uint32_t* pairs, std::size_t count, const float* sums, float* out);
void sum_pairs_16(const std::uint32_t* pairs, std::size_t count, const float* sums, float* out);

PANOPTIC_CLONES
std::size_t find_pairs(const PairWork& work) {
  std::size_t count = 0;
  for (const ClusterRange range : work.candidates) {
    for (std::size_t first = range.first; first < range.past; first += kLanes) {
      Lanes squares = {};
      for (const float* axis : work.axes) {
        Lanes difference;
        std::memcpy(&difference, axis + first, sizeof difference);
        difference -= axis[work.cluster];
        squares += difference * difference;
      }
      Lanes weight = -squares;
      fast_exp(weight);
      float weights[kLanes];
      std::memcpy(weights, &weight, sizeof weights);
      const std::size_t lanes = range.past - first < kLanes ? range.past - first : kLanes;
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        work.found[2 * count] = static_cast<std::uint32_t>(first + lane);
        work.found[2 * count + 1] = std::bit_cast<std::uint32_t>(weights[lane]);
        count += weights[lane] > work.least ? 1 : 0;
      }
    }
  }
  return count;
}

template <std::size_t Width>
[[gnu::always_inline]] inline void sum_pairs(const std::uint32_t* pairs, std::size_t count, const float* sums, float* out) {
  LaneRow<Width> total{};
  for (std::size_t i = 0; i < count; ++i) {
    total.add(std::bit_cast<float>(pairs[2 * i + 1]), sums + std::size_t{pairs[2 * i]} * Width);
  }
  total.store(out);
}

PANOPTIC_CLONES
void sum_pairs_8(const std::uint32_t* pairs, std::size_t count, const float* sums, float* out) {
  sum_pairs<8>(pairs, count, sums, out);
}

PANOPTIC_CLONES
void sum_pairs_16(const std::uint32_t* pairs, std::size_t count, const float* sums, float* out) {
  sum_pairs<16>(pairs, count, sums, out);
}

}  // namespace kernels

ColorFilter::ColorFilter(std::span<const GridPoint> points, std::span<const VoxelColor> colors,
                         const ColorFilterSettings& settings, const Ranges& ranges) {
  const auto cell_voxels = std::max(1, static_cast<std::int32_t>(settings.theta_alpha));
  const std::vector<GridPoint> cells = cells_of(points, cell_voxels);
  Centers centers(box_around(cells));
  form_clusters(points, colors, settings, cells, centers);
  pair_clusters(centers, std::sqrt(2 * kFarthest) * settings.theta_alpha / static_cast<float>(cell_voxels), ranges);
}

// Voxels sorted by cell; within a cell each joins the first cluster of its colour, or founds one.
void ColorFilter::form_clusters(std::span<const GridPoint> points, std::span<const VoxelColor> colors,
                                const ColorFilterSettings& settings, std::span<const GridPoint> cells, Centers& centers) {
  const GridPoint origin = centers.cells.box().origin;
  const auto within = [&](const GridPoint& c) { return GridPoint{c.x - origin.x, c.y - origin.y, c.z - origin.z}; };
  for (const GridPoint& c : cells) centers.cells.set(within(c));
  const std::size_t cell_count = centers.cells.number_points();
  std::vector<std::uint32_t> starts(cell_count + 1, 0);
  std::vector<std::uint32_t> cell(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    cell[i] = centers.cells.rank(within(cells[i]));
    starts[cell[i] + 1]++;
  }
  std::partial_sum(starts.begin(), starts.end(), starts.begin());
  std::vector<std::uint32_t> sorted(points.size());
  std::vector<std::uint32_t> next(starts.begin(), starts.end() - 1);
  for (std::size_t i = 0; i < points.size(); ++i) sorted[next[cell[i]]++] = static_cast<std::uint32_t>(i);

  const float limit = kSameColor * settings.theta_beta * kSameColor * settings.theta_beta;
  const double position_scale = 1 / (std::sqrt(2.0) * settings.theta_alpha);
  const double color_scale = 1 / (std::sqrt(2.0) * settings.theta_beta);
  cluster_of_.resize(points.size());
  members_.reserve(points.size());
  std::vector<std::uint32_t> left;
  for (std::size_t c = 0; c < cell_count; ++c) {
    centers.first_of.push_back(static_cast<std::uint32_t>(member_ends_.size()));
    left.assign(sorted.begin() + starts[c], sorted.begin() + starts[c + 1]);
    while (!left.empty()) {
      const VoxelColor seed = colors[left[0]];
      const auto rest = std::stable_partition(left.begin(), left.end(),
                                              [&](std::uint32_t i) { return squared_difference(colors[i], seed) >= limit; });
      std::array<double, 6> sum{};
      for (auto i = rest; i != left.end(); ++i) {
        const GridPoint& p = points[*i];
        cluster_of_[*i] = static_cast<std::uint32_t>(member_ends_.size());
        members_.push_back(*i);
        sum[0] += p.x - origin.x * 1.0;
        sum[1] += p.y - origin.y * 1.0;
        sum[2] += p.z - origin.z * 1.0;
        for (std::size_t a = 0; a < 3; ++a) sum[3 + a] += colors[*i][a];
      }
      const auto members = static_cast<double>(left.end() - rest);
      for (std::size_t a = 0; a < 6; ++a) {
        centers.axes[a].push_back(static_cast<float>(sum[a] / members * (a < 3 ? position_scale : color_scale)));
      }
      centers.cell_of.push_back(within(cells[sorted[starts[c]]]));
      member_ends_.push_back(static_cast<std::uint32_t>(members_.size()));
      left.erase(rest, left.end());
    }
  }
  centers.first_of.push_back(static_cast<std::uint32_t>(member_ends_.size()));
  for (auto& axis : centers.axes) axis.insert(axis.end(), kLanes, 0.0F);  // read, but never used
}

// The clusters of the cells within reach of a cell.
void ColorFilter::collect(const Centers& centers, GridPoint at, float reach_cells, std::vector<ClusterRange>& ranges) {
  // Clusters within the reach lie in cells at most one cell farther apart.
  const auto squared_reach = static_cast<std::int32_t>((reach_cells + 1) * (reach_cells + 1));
  const auto reach = static_cast<std::int32_t>(reach_cells + 1);
  const GridPoint size = centers.cells.box().size;
  ranges.clear();
  for (std::int32_t z = std::max(0, at.z - reach); z <= std::min(size.z - 1, at.z + reach); ++z) {
    for (std::int32_t y = std::max(0, at.y - reach); y <= std::min(size.y - 1, at.y + reach); ++y) {
      const std::int32_t left = squared_reach - (z - at.z) * (z - at.z) - (y - at.y) * (y - at.y);
      if (left < 0) continue;
      const auto across = static_cast<std::int32_t>(std::sqrt(static_cast<float>(left)));
      const GridPoint low{std::max(0, at.x - across), y, z};
      const GridPoint high{std::min(size.x - 1, at.x + across), y, z};
      // The cells of a row are numbered one after the other, and so are their clusters.
      const std::uint32_t first = centers.first_of[centers.cells.rank(low)];
      const std::uint32_t past = centers.first_of[centers.cells.rank(high) + (centers.cells.contains(high) ? 1U : 0U)];
      if (first < past) ranges.push_back({first, past});
    }
  }
}

void ColorFilter::pair_clusters(const Centers& centers, float reach_cells, const Ranges& threads) {
  pairs_.resize((cluster_count() + kGrain - 1) / kGrain);
  threads.run(cluster_count(), kGrain, [&](std::size_t begin, std::size_t end) {
    Pairs& piece = pairs_[begin / kGrain];
    std::vector<ClusterRange> candidates;
    std::vector<Pair> found;
    kernels::PairWork work{{}, 0, {}, static_cast<float>(std::exp(-double{kFarthest})), nullptr};
    for (std::size_t a = 0; a < 6; ++a) work.axes[a] = centers.axes[a].data();
    for (std::size_t c = begin; c < end; ++c) {
      if (c == begin || !(centers.cell_of[c] == centers.cell_of[c - 1])) {
        collect(centers, centers.cell_of[c], reach_cells, candidates);
        std::size_t room = kLanes;
        for (const ClusterRange& range : candidates) room += range.past - range.first;
        found.resize(std::max(found.size(), room));
        work.candidates = candidates;
        work.found = &found[0].cluster;
      }
      work.cluster = c;
      const auto count = static_cast<std::ptrdiff_t>(kernels::find_pairs(work));
      piece.pairs.insert(piece.pairs.end(), found.begin(), found.begin() + count);
      piece.ends.push_back(static_cast<std::uint32_t>(piece.pairs.size()));
    }
  });
}

const float* ColorFilter::apply(const ScaledRows& in, RowWidth row_width, ColorScratch& scratch, const Ranges& ranges) const {
  const auto width = static_cast<std::size_t>(row_width);
  scratch.sums.resize(std::max(scratch.sums.size(), cluster_count() * width));
  scratch.blurred.resize(std::max(scratch.blurred.size(), cluster_count() * width));
  ranges.run(cluster_count(), kGrain, [&](std::size_t begin, std::size_t end) {
    std::size_t m = begin == 0 ? 0 : member_ends_[begin - 1];
    for (std::size_t k = begin; k < end; ++k) {
      float* sum = scratch.sums.data() + k * width;
      std::fill(sum, sum + width, 0.0F);
      for (; m < member_ends_[k]; ++m) {
        const float factor = in.scale == nullptr ? 1.0F : in.scale[members_[m]];
        const float* from = in.row(members_[m]);
        for (std::size_t c = 0; c < width; ++c) sum[c] += factor * from[c];
      }
    }
  });
  const auto sum_pairs = row_width == RowWidth::k8 ? kernels::sum_pairs_8 : kernels::sum_pairs_16;
  ranges.run(cluster_count(), kGrain, [&](std::size_t begin, std::size_t end) {
    const Pairs& piece = pairs_[begin / kGrain];
    std::size_t first = 0;
    for (std::size_t k = begin; k < end; ++k) {
      const std::size_t past = piece.ends[k - begin];
      sum_pairs(&piece.pairs[first].cluster, past - first, scratch.sums.data(), scratch.blurred.data() + k * width);
      first = past;
    }
  });
  return scratch.blurred.data();
}

std::size_t ColorFilter::memory_bytes() const {
  std::size_t bytes = (cluster_of_.capacity() + members_.capacity() + member_ends_.capacity()) * sizeof(std::uint32_t);
  for (const Pairs& piece : pairs_) {
    bytes += piece.pairs.capacity() * sizeof(Pair) + piece.ends.capacity() * sizeof(std::uint32_t);
  }
  return bytes;
}

}  // namespace panoptic
