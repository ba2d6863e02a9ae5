// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/crf/color_filter.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "panoptic/base/lanes.h"
#include "panoptic/crf/color_kernels.h"

namespace panoptic {
namespace {

// Pairs whose weight is below e^-kCutExponent are left out.
constexpr float kCutExponent = 5.0F;
// A voxel joins a cluster whose first voxel's colour is nearer than this share of theta_beta.
constexpr float kSameColor = 1.0F;
constexpr std::int32_t kCellsTogether = 4;

float squared_difference(const VoxelColor& a, const VoxelColor& b) {
  return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]);
}

// Room for the pairs of some clusters: kept, because fresh memory costs as much as finding them.
std::vector<ClusterPair>& thread_pairs() {
  thread_local std::vector<ClusterPair> pairs;
  return pairs;
}

std::vector<GridPoint> cells_of(std::span<const GridPoint> points, std::int32_t side) {
  std::vector<GridPoint> cells;
  cells.reserve(points.size());
  for (const GridPoint& p : points) cells.push_back(cell_of(p, side));
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

ColorFilter::ColorFilter(std::span<const GridPoint> points, std::span<const VoxelColor> colors,
                         const ColorFilterSettings& settings, const Ranges& ranges) {
  const auto cell_voxels = std::max(1, static_cast<std::int32_t>(settings.theta_alpha));
  const std::vector<GridPoint> cells = cells_of(points, cell_voxels);
  Centers centers(box_around(cells));
  form_clusters(points, colors, settings, cells, centers);
  pair_clusters(centers, settings, cell_voxels, ranges);
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

// The clusters of the cells within reach of some cells of a row, their coordinates side by side. Finding them takes longer than
// looking at a few more of them.
class ColorFilter::Candidates {
 public:
  // Pairs of voxels are nearer than their cells by up to `slack`, along each axis.
  Candidates(const Centers& centers, double reach_cells, double slack) : centers_(centers) {
    const auto nearest = [&](std::int32_t cells) { return std::max(0.0, std::abs(cells) - slack); };
    const auto reach = static_cast<std::int32_t>(reach_cells + slack);
    for (std::int32_t z = -reach; z <= reach; ++z) {
      for (std::int32_t y = -reach; y <= reach; ++y) {
        const double left = reach_cells * reach_cells - nearest(z) * nearest(z) - nearest(y) * nearest(y);
        if (left >= 0) rows_.push_back({static_cast<std::int32_t>(std::sqrt(left) + slack), y, z});
      }
    }
  }

  // Collects the clusters from `first` on that lie in a few cells of a row; returns the end of them, at most `end`.
  std::size_t collect(std::size_t first, std::size_t end) {
    const GridPoint at = centers_.cell_of[first];
    std::size_t past = first + 1;
    const auto together = [&](const GridPoint& cell) {
      return cell.z == at.z && cell.y == at.y && cell.x < at.x + kCellsTogether;
    };
    while (past < end && together(centers_.cell_of[past])) ++past;
    collect_around(at, centers_.cell_of[past - 1].x);
    return past;
  }

  // Adds those of them that pair with a cluster; returns how many pairs there are now.
  std::size_t find(std::size_t cluster) {
    if (pairs_.size() < pair_count_ + count_) pairs_.resize(2 * (pair_count_ + count_));
    kernels::PairWork work{{},           clusters_.data(), count_,          {},
                           kCutExponent, near_.data(),     weights_.data(), pairs_.data() + pair_count_};
    for (std::size_t a = 0; a < 6; ++a) {
      work.axes[a] = axes_[a].data();
      work.center[a] = centers_.axes[a][cluster];
    }
    pair_count_ += kernels::find_pairs(work);
    return pair_count_;
  }
  // All pairs found so far.
  std::vector<ClusterPair> pairs() const { return {pairs_.begin(), pairs_.begin() + static_cast<std::ptrdiff_t>(pair_count_)}; }

 private:
  static constexpr float kNowhere = 1e15F;

  struct Range {
    std::uint32_t first;
    std::uint32_t past;
  };

  // Collects around the cells from one to that with coordinate `last_x` in the same row.
  void collect_around(GridPoint at, std::int32_t last_x) {
    const GridPoint size = centers_.cells.box().size;
    ranges_.clear();
    count_ = 0;
    for (const GridPoint& row : rows_) {
      const std::int32_t y = at.y + row.y;
      const std::int32_t z = at.z + row.z;
      if (y < 0 || y >= size.y || z < 0 || z >= size.z) continue;
      const GridPoint low{std::max(0, at.x - row.x), y, z};
      const GridPoint high{std::min(size.x - 1, last_x + row.x), y, z};
      if (!centers_.cells.any_between(low, high)) continue;
      // The cells of a row are numbered one after the other, and so are their clusters.
      ranges_.push_back({centers_.first_of[centers_.cells.rank(low)],
                         centers_.first_of[centers_.cells.rank(high) + (centers_.cells.contains(high) ? 1U : 0U)]});
      count_ += ranges_.back().past - ranges_.back().first;
    }
    copy_ranges();
  }

  // Eight at once, and what is too many is overwritten by the next range: most are short.
  void copy_ranges() {
    make_room(count_ + 4 * kLanes);
    std::size_t to = 0;
    for (const Range range : ranges_) {
      for (std::uint32_t from = range.first; from < range.past; from += kLanes) {
        const std::size_t at = to + (from - range.first);
        for (std::size_t a = 0; a < 6; ++a) {
          std::memcpy(axes_[a].data() + at, centers_.axes[a].data() + from, kLanes * sizeof(float));
        }
        for (std::uint32_t lane = 0; lane < kLanes; ++lane) clusters_[at + lane] = from + lane;
      }
      to += range.past - range.first;
    }
    for (; count_ % (2 * kLanes) != 0; ++count_) {
      for (auto& axis : axes_) axis[count_] = kNowhere;
    }
  }
  void make_room(std::size_t count) {
    if (count <= clusters_.size()) return;
    for (auto& axis : axes_) axis.resize(count);
    clusters_.resize(count);
    near_.resize(count);
    weights_.resize(count);
  }

  const Centers& centers_;
  std::vector<GridPoint> rows_;  // of cells: y and z from the middle one, and how far they reach along x
  std::vector<Range> ranges_;    // of clusters that follow each other
  std::size_t count_ = 0;
  std::array<std::vector<float>, 6> axes_;
  std::vector<std::uint32_t> clusters_;
  std::vector<std::uint32_t> near_;
  std::vector<float> weights_;
  std::vector<ClusterPair>& pairs_ = thread_pairs();
  std::size_t pair_count_ = 0;
};

void ColorFilter::pair_clusters(const Centers& centers, const ColorFilterSettings& settings, int cell_voxels,
                                const Ranges& threads) {
  // A little more than that, because positions are rounded.
  const double reach_cells = 1.0001 * std::sqrt(2.0 * kCutExponent) * settings.theta_alpha / cell_voxels;
  const double slack = (cell_voxels - 1.0) / cell_voxels;
  pairs_.resize((cluster_count() + kGrain - 1) / kGrain);
  threads.run(cluster_count(), kGrain, [&](std::size_t begin, std::size_t end) {
    Pairs& piece = pairs_[begin / kGrain];
    Candidates candidates(centers, reach_cells, slack);
    piece.ends.reserve(end - begin);
    for (std::size_t past = begin; begin < end; begin = past) {
      past = candidates.collect(begin, end);
      for (std::size_t c = begin; c < past; ++c) piece.ends.push_back(static_cast<std::uint32_t>(candidates.find(c)));
    }
    piece.pairs = candidates.pairs();
  });
}

const float* ColorFilter::apply(const ScaledRows& in, RowWidth row_width, ColorScratch& scratch, const Ranges& ranges) const {
  const auto width = static_cast<std::size_t>(row_width);
  float* sums = scratch.sums.make_room(cluster_count() * width);
  float* blurred = scratch.blurred.make_room(cluster_count() * width);
  ranges.run(cluster_count(), kGrain, [&](std::size_t begin, std::size_t end) {
    const std::span ends(member_ends_.data() + begin, end - begin);
    const std::size_t first = begin == 0 ? 0 : member_ends_[begin - 1];
    kernels::sum_members({{ends, first, sums + begin * width}, members_.data(), members_.size(), in}, row_width);
  });
  ranges.run(pairs_.size(), 1, [&](std::size_t piece, std::size_t) {
    const Pairs& pairs = pairs_[piece];
    kernels::sum_pairs({{pairs.ends, 0, blurred + piece * kGrain * width}, pairs.pairs.data(), sums}, row_width);
  });
  return blurred;
}

std::size_t ColorFilter::memory_bytes() const {
  std::size_t bytes = (cluster_of_.capacity() + members_.capacity() + member_ends_.capacity()) * sizeof(std::uint32_t);
  for (const Pairs& piece : pairs_) {
    bytes += piece.pairs.capacity() * sizeof(ClusterPair) + piece.ends.capacity() * sizeof(std::uint32_t);
  }
  return bytes;
}

}  // namespace panoptic
