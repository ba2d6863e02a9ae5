// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Sums over voxels weighted by a Gaussian of their distance and of the difference of their colours: k1 of the paper (Eq. 15).
//
// Voxels that share a cell of about one sigma and nearly one colour form a cluster; clusters are summed pair by pair, with their
// mean positions and colours. Surfaces are thin and locally of few colours, so there are few clusters, each with some hundred
// others in reach, and the weights are worked out once. docs/decisions/0008-crf.md says why there is no lattice.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "panoptic/base/ranges.h"
#include "panoptic/crf/bit_grid.h"
#include "panoptic/crf/color_kernels.h"
#include "panoptic/crf/float_rows.h"
#include "panoptic/crf/grid_filter.h"

namespace panoptic {

using VoxelColor = std::array<float, 3>;  // 0..255

struct ColorFilterSettings {
  float theta_alpha = 2;  // voxels
  float theta_beta = 20;  // of 255
};

struct ColorScratch {
  FloatRows sums;     // a row per cluster
  FloatRows blurred;  // a row per cluster
};

class ColorFilter {
 public:
  // `points` in the order of (z, y, x), none twice.
  ColorFilter(std::span<const GridPoint> points, std::span<const VoxelColor> colors, const ColorFilterSettings& settings,
              const Ranges& ranges);

  // Returns rows r, one per cluster: voxel i's sum over j of k1(i, j) * scale[j] * row j of `in`, j = i included, is
  // row cluster_of()[i]. A voxel's own share in it is exactly scale[i] * row i.
  const float* apply(const ScaledRows& in, RowWidth width, ColorScratch& scratch, const Ranges& ranges) const;

  std::span<const std::uint32_t> cluster_of() const { return cluster_of_; }
  std::size_t cluster_count() const { return member_ends_.size(); }
  std::size_t memory_bytes() const;

 private:
  static constexpr std::size_t kGrain = 512;  // clusters that are worked together

  struct Pairs {  // of kGrain clusters
    std::vector<ClusterPair> pairs;
    std::vector<std::uint32_t> ends;
  };
  struct Centers;
  class Candidates;

  void form_clusters(std::span<const GridPoint> points, std::span<const VoxelColor> colors, const ColorFilterSettings& settings,
                     std::span<const GridPoint> cells, Centers& centers);
  void pair_clusters(const Centers& centers, const ColorFilterSettings& settings, int cell_voxels, const Ranges& threads);

  std::vector<std::uint32_t> cluster_of_;   // by voxel
  std::vector<std::uint32_t> members_;      // voxels, cluster after cluster
  std::vector<std::uint32_t> member_ends_;  // by cluster
  std::vector<Pairs> pairs_;
};

}  // namespace panoptic
