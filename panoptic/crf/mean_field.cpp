// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/crf/mean_field.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "panoptic/base/lanes.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr std::size_t kGrain = 512;  // voxels that are worked together: their labels stay in the cache
constexpr std::size_t kWidest = 32;  // columns of a chunk

// Every voxel belongs to some sum of at least its own 1, so the root is of something positive.
float inverse_root(float sum) { return 1.0F / std::sqrt(sum); }

}  // namespace

std::size_t MeanFieldScratch::memory_bytes() const {
  return (rows.capacity() + grid.rows.capacity() + color.sums.capacity() + color.blurred.capacity()) * sizeof(float);
}

MeanField::MeanField(const CrfGraph& graph, const MeanFieldSettings& settings, MeanFieldScratch& scratch, Ranges ranges)
    : graph_(graph),
      settings_(settings),
      scratch_(scratch),
      ranges_(ranges),
      grid_filter_(graph.points, settings.theta_alpha, ranges),
      color_filter_(graph.points, graph.colors, {settings.theta_alpha, settings.theta_beta}, ranges),
      color_norm_(graph.size()),
      grid_norm_(graph.size()),
      head_start_(graph.size()),
      label_columns_(graph.points, graph.labels, graph.label_count, grid_filter_.reach()),
      own_column_(graph.size()) {
  PANOPTIC_ASSERT(graph.size() > 0 && graph.label_count > 0 && graph.all_labels >= graph.label_count);
  const std::size_t columns = (label_columns_.count() + kLanes - 1) / kLanes * kLanes;
  float* rows = scratch_.rows.make_room(graph.size() * columns);
  normalise_kernels();
  set_head_starts();
  is_label_.assign(columns, 0.0F);
  std::fill_n(is_label_.begin(), label_columns_.count(), 1.0F);
  add_chunks(columns, rows);
  ranges_.run(graph.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t> voxels(end - begin);
    std::iota(voxels.begin(), voxels.end(), static_cast<std::uint32_t>(begin));
    for (const Chunk& chunk : chunks_) {
      const auto width = static_cast<std::size_t>(chunk.width);
      std::fill(chunk.rows + begin * width, chunk.rows + end * width, 0.0F);
    }
    kernels::softmax_rows(marginal_work(), voxels);
  });
}

// Makes as few chunks as possible, as equal as possible: most of the time goes by rows, not by labels.
void MeanField::add_chunks(std::size_t columns, float* rows) {
  std::size_t left = (columns + kWidest - 1) / kWidest;
  for (std::size_t label = 0; label < columns; --left) {
    const std::size_t width = ((columns - label) / kLanes + left - 1) / left * kLanes;
    float* const first = rows + label * graph_.size();
    chunks_.push_back({static_cast<RowWidth>(width), first});
    for (std::size_t column = 0; column < width; ++column) columns_.push_back({first + column, width});
    for (std::size_t group = 0; group < width;) {
      const std::size_t count = has_wide_registers() && width - group >= 2 * kLanes ? 2 * kLanes : kLanes;
      groups_.push_back({first + group, width, count, is_label_.data() + label + group});
      group += count;
    }
    label += width;
  }
}

// The kernels' row sums: what the filters make of ones.
void MeanField::normalise_kernels() {
  float* ones = scratch_.rows.data();
  std::fill_n(ones, graph_.size() * kLanes, 1.0F);
  const ScaledRows in{ones, kLanes, nullptr};
  const float* color_sums = color_filter_.apply(in, RowWidth::k8, scratch_.color, ranges_);
  const std::span<const std::uint32_t> cluster_of = color_filter_.cluster_of();
  grid_filter_.apply(in, RowWidth::k8, scratch_.grid, ranges_, [&](std::span<const std::uint32_t> voxels, const float* sums) {
    for (std::size_t k = 0; k < voxels.size(); ++k) {
      grid_norm_[voxels[k]] = inverse_root(sums[k * kLanes]);
      color_norm_[voxels[k]] = inverse_root(color_sums[cluster_of[voxels[k]] * kLanes]);
    }
  });
}

void MeanField::set_head_starts() {
  // In double: rounded to float it is the same whichever of its variants for this CPU the library takes.
  const double others = static_cast<double>(graph_.all_labels) - 1;
  ranges_.run(graph_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const double p = graph_.probabilities[i];
      head_start_[i] = others < 1 ? 0.0F : static_cast<float>(std::log(p * others / (1 - p)));
      const std::uint16_t label = graph_.labels[i];
      own_column_[i] = label < graph_.label_count ? label_columns_.column_of(label) : -1;
    }
  });
}

void MeanField::iterate() {
  for (const Chunk& chunk : chunks_) pass_messages(chunk, &chunk == &chunks_.back());
}

// Marginals of some labels to their messages, in place: no label's message depends on another label. Once the last ones are
// there, they become marginals while they are in the cache.
void MeanField::pass_messages(const Chunk& chunk, bool last) {
  const auto width = static_cast<std::size_t>(chunk.width);
  const float* color_sums = color_filter_.apply({chunk.rows, width, color_norm_.data()}, chunk.width, scratch_.color, ranges_);
  const auto take = [&](std::span<const std::uint32_t> voxels, const float* sums) {
    const kernels::MessageWork messages{
        voxels,       sums,         color_sums, color_filter_.cluster_of().data(), color_norm_.data(), grid_norm_.data(),
        settings_.w1, settings_.w2, chunk.rows};
    if (chunks_.size() == 1) return kernels::renew_rows(messages, marginal_work(), chunk.width);
    kernels::combine_rows(messages, chunk.width);
    if (last) kernels::softmax_rows(marginal_work(), voxels);
  };
  grid_filter_.apply({chunk.rows, width, grid_norm_.data()}, chunk.width, scratch_.grid, ranges_, take);
}

kernels::MarginalWork MeanField::marginal_work() const {
  const auto absent = static_cast<float>(graph_.label_count - label_columns_.count());
  return {groups_, own_column_.data(), head_start_.data(), absent};
}

// The marginal of a label that is out of the voxel's reach. If there may be such labels, rows hold differences from it.
float MeanField::absent_marginal(std::size_t voxel) const {
  if (!label_columns_.shared()) return 0;
  float sum = 0;
  for (std::size_t column = 0; column < label_columns_.count(); ++column) sum += value_at(voxel, column);
  return std::max(0.0F, 1 - sum) / static_cast<float>(graph_.label_count);
}

float MeanField::marginal(std::size_t voxel, std::size_t label) const {
  const std::size_t column = label_columns_.column_of(static_cast<std::uint16_t>(label));
  const bool here = label_columns_.label_at(column, graph_.points[voxel]) == label;
  return std::max(0.0F, absent_marginal(voxel) + (here ? value_at(voxel, column) : 0.0F));
}

MeanField::Best MeanField::best(std::size_t voxel) const {
  float most = value_at(voxel, 0);
  std::size_t column = 0;
  std::size_t equal = 1;
  for (std::size_t c = 1; c < label_columns_.count(); ++c) {
    const float value = value_at(voxel, c);
    equal = value > most ? 1 : equal + (value == most ? 1 : 0);
    column = value > most ? c : column;
    most = value > most ? value : most;
  }
  std::uint16_t label = label_columns_.label_at(column, graph_.points[voxel]);
  for (std::size_t c = column + 1; equal > 1 && c < label_columns_.count(); ++c) {
    if (value_at(voxel, c) == most) label = std::min(label, label_columns_.label_at(c, graph_.points[voxel]));
  }
  return {label, most + absent_marginal(voxel)};
}

std::size_t MeanField::memory_bytes() const {
  return 4 * graph_.size() * sizeof(float) + scratch_.memory_bytes() + grid_filter_.memory_bytes() + color_filter_.memory_bytes();
}

}  // namespace panoptic
