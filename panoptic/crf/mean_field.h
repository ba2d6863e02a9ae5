// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Mean-field inference in the fully connected CRF of the paper (Eq. 13-20, after Kraehenbuehl and Koltun 2011), on a graph that
// knows nothing of maps.
//
// With kernels k1, k2 that both leave out the voxel itself, symmetrically normalised as n_v n_u k(v, u), n_v = (sum over u, v
// included, of k(v, u))^-1/2, one iteration sets every voxel's marginals to
//   q_v(l) ~ p_v(l) exp(w1 sum_u n1_v n1_u k1(v, u) q_u(l) + w2 sum_u n2_v n2_u k2(v, u) q_u(l)),
// starting from q = p. Normalised, the weights mean the same in a corner and on a plane, whatever the voxel size; without it some
// hundred neighbours would drown p.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "panoptic/crf/color_filter.h"
#include "panoptic/crf/grid_filter.h"
#include "panoptic/crf/label_columns.h"
#include "panoptic/crf/mean_field_kernels.h"

namespace panoptic {

struct MeanFieldSettings {
  float w1 = 10;          // of k1, position and colour
  float w2 = 15;          // of k2, position alone
  float theta_alpha = 2;  // voxels
  float theta_beta = 20;  // of 255
};

// The voxels and what is known of each: one label with a probability, all other labels sharing the rest (Eq. 19, 20).
struct CrfGraph {
  std::vector<GridPoint> points;  // in the order of (z, y, x), none twice
  std::vector<VoxelColor> colors;
  std::vector<std::uint16_t> labels;  // 0 .. label_count - 1; kOtherLabel: one that is not among them; kNoLabel: nothing is known
  std::vector<float> probabilities;   // above 0, below 1; of voxels of which nothing is known, none: all labels are as probable
  std::size_t label_count = 0;        // columns
  std::size_t all_labels = 0;         // M of Eq. 20: label_count and those that have no column

  static constexpr std::uint16_t kOtherLabel = 65534;
  static constexpr std::uint16_t kNoLabel = 65535;
  std::size_t size() const { return points.size(); }
};

// The working memory of a MeanField, for one of them after the other: memory fresh from the operating system costs a tenth of
// the time.
struct MeanFieldScratch {
  FloatRows rows;
  GridScratch grid;
  ColorScratch color;

  std::size_t memory_bytes() const;
};

class MeanField {
 public:
  struct Best {
    std::uint16_t label;
    float probability;
  };

  // Keeps references to the graph and to the scratch. REQUIRES at least one voxel and one label.
  MeanField(const CrfGraph& graph, const MeanFieldSettings& settings, MeanFieldScratch& scratch, Ranges ranges = {});

  void iterate();

  float marginal(std::size_t voxel, std::size_t label) const;
  Best best(std::size_t voxel) const;  // the lower label of equally probable ones

  // The memory that this graph takes, scratch included, without the graph itself.
  std::size_t memory_bytes() const;

 private:
  // Columns that are worked together. Their values lie side by side: `width` per voxel, voxel after voxel.
  struct Chunk {
    RowWidth width;
    float* rows;
  };

  struct Column {
    float* rows;
    std::size_t stride;
  };

  float value_at(std::size_t voxel, std::size_t column) const { return columns_[column].rows[voxel * columns_[column].stride]; }
  float absent_marginal(std::size_t voxel) const;
  kernels::MarginalWork marginal_work() const;
  void add_chunks(std::size_t columns, float* rows);
  void normalise_kernels();
  void set_head_starts();
  void pass_messages(const Chunk& chunk, bool last);

  const CrfGraph& graph_;
  MeanFieldSettings settings_;
  MeanFieldScratch& scratch_;
  Ranges ranges_;
  GridFilter grid_filter_;
  ColorFilter color_filter_;
  std::vector<float> color_norm_;  // n1
  std::vector<float> grid_norm_;   // n2
  std::vector<float> head_start_;  // log of how much more probable the known label is than another one
  LabelColumns label_columns_;
  std::vector<std::int32_t> own_column_;  // that of the known label; -1: none
  std::vector<Chunk> chunks_;
  std::vector<Column> columns_;
  std::vector<ColumnGroup> groups_;  // of all chunks
  std::vector<float> is_label_;      // by column
};

}  // namespace panoptic
