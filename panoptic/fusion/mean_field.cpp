// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/mean_field.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "panoptic/base/clones.h"
#include "panoptic/base/error.h"
#include "panoptic/fusion/fast_exp.h"
#include "panoptic/fusion/lanes.h"

namespace panoptic {
namespace {

constexpr std::size_t kGrain = 512;     // voxels that are worked together: their labels stay in the cache
constexpr std::size_t kWidest = 32;     // labels of a chunk
constexpr std::size_t kAhead = 8;       // rows that are fetched before they are needed
constexpr std::size_t kCacheLine = 16;  // floats

// Every voxel belongs to some sum of at least its own 1, so the root is of something positive.
float inverse_root(float sum) { return 1.0F / std::sqrt(sum); }

}  // namespace

// External linkage on purpose: GCC's target_clones need it.
namespace kernels {

// What messages are made of: the kernels' sums, and the own marginals, in whose place they come.
struct MessageWork {
  std::span<const std::uint32_t> voxels;
  const float* grid_sums;           // a row for each of them
  const float* color_sums;          // by cluster
  const std::uint32_t* cluster_of;  // by voxel, as all below
  const float* color_norm;
  const float* grid_norm;
  float w1;
  float w2;
  float* rows;
};

void combine_8(const MessageWork& work);
void combine_16(const MessageWork& work);
void combine_24(const MessageWork& work);
void combine_32(const MessageWork& work);
void softmax_rows(std::span<const LabelGroup> groups, std::span<const std::uint32_t> voxels);
void softmax_rows_wide(std::span<const LabelGroup> groups, std::span<const std::uint32_t> voxels);

template <std::size_t Width>
[[gnu::always_inline]] inline void combine(const MessageWork& work) {
  const float* grid = work.grid_sums;
  const std::size_t last = work.voxels.size() - 1;
  for (std::size_t k = 0; k <= last; ++k) {
    const std::size_t i = work.voxels[k];
    const float* later = work.rows + std::size_t{work.voxels[k + kAhead < last ? k + kAhead : last]} * Width;
    __builtin_prefetch(later);
    if constexpr (Width > kCacheLine) __builtin_prefetch(later + Width - 1);
    const float color_factor = work.w1 * work.color_norm[i];
    const float grid_factor = work.w2 * work.grid_norm[i];
    const float own_factor = color_factor * work.color_norm[i] + grid_factor * work.grid_norm[i];
    const float* color = work.color_sums + std::size_t{work.cluster_of[i]} * Width;
    float* row = work.rows + i * Width;
    for (std::size_t c = 0; c < Width; ++c) row[c] = color_factor * color[c] + grid_factor * grid[c] - own_factor * row[c];
    grid += Width;
  }
}

PANOPTIC_CLONES void combine_8(const MessageWork& work) { combine<8>(work); }
PANOPTIC_CLONES void combine_16(const MessageWork& work) { combine<16>(work); }
PANOPTIC_CLONES void combine_24(const MessageWork& work) { combine<24>(work); }
PANOPTIC_CLONES void combine_32(const MessageWork& work) { combine<32>(work); }

void combine_rows(const MessageWork& work, RowWidth width) {
  switch (width) {
    case RowWidth::k8:
      return combine_8(work);
    case RowWidth::k16:
      return combine_16(work);
    case RowWidth::k24:
      return combine_24(work);
    case RowWidth::k32:
      return combine_32(work);
  }
}

// The highest of eight, and their sum in a fixed order, in all of them.
[[gnu::always_inline]] inline void spread_highest(Lanes& x) {
  Lanes other = __builtin_shufflevector(x, x, 4, 5, 6, 7, 0, 1, 2, 3);
  x = x > other ? x : other;
  other = __builtin_shufflevector(x, x, 2, 3, 0, 1, 6, 7, 4, 5);
  x = x > other ? x : other;
  other = __builtin_shufflevector(x, x, 1, 0, 3, 2, 5, 4, 7, 6);
  x = x > other ? x : other;
}
[[gnu::always_inline]] inline void spread_sum(Lanes& x) {
  x += __builtin_shufflevector(x, x, 4, 5, 6, 7, 0, 1, 2, 3);
  x += __builtin_shufflevector(x, x, 1, 0, 3, 2, 5, 4, 7, 6);
  x += __builtin_shufflevector(x, x, 2, 3, 0, 1, 6, 7, 4, 5);
}

// Sixteen as eight and eight, so that the order of the sums does not depend on the width.
[[gnu::always_inline]] inline void take_highest(Lanes& most, const Lanes& x) { most = x > most ? x : most; }
[[gnu::always_inline]] inline void take_highest(Lanes& most, const WideLanes& x) {
  take_highest(most, __builtin_shufflevector(x, x, 0, 1, 2, 3, 4, 5, 6, 7));
  take_highest(most, __builtin_shufflevector(x, x, 8, 9, 10, 11, 12, 13, 14, 15));
}
[[gnu::always_inline]] inline void add_to(Lanes& sums, const Lanes& x) { sums += x; }
[[gnu::always_inline]] inline void add_to(Lanes& sums, const WideLanes& x) {
  sums += __builtin_shufflevector(x, x, 0, 1, 2, 3, 4, 5, 6, 7);
  sums += __builtin_shufflevector(x, x, 8, 9, 10, 11, 12, 13, 14, 15);
}

template <typename Part>
[[gnu::always_inline]] inline void find_highest(const LabelGroup& group, std::size_t i, Lanes& most) {
  Part logits;
  load_lanes(group.rows + i * group.stride, logits);
  take_highest(most, logits);
}
template <typename Part>
[[gnu::always_inline]] inline void raise(const LabelGroup& group, std::size_t i, float most, Lanes& sums) {
  float* row = group.rows + i * group.stride;
  Part value;
  Part is_label;
  load_lanes(row, value);
  load_lanes(group.is_label, is_label);
  value -= most;
  fast_exp(value);
  value *= is_label;
  add_to(sums, value);
  store_lanes(value, row);
}
template <typename Part>
[[gnu::always_inline]] inline void scale(const LabelGroup& group, std::size_t i, float share) {
  float* row = group.rows + i * group.stride;
  Part value;
  load_lanes(row, value);
  value *= share;
  store_lanes(value, row);
}

// Logits to probabilities; columns where is_label is 0 become 0. `Most` values of a group at once if it has so many.
template <typename Most>
[[gnu::always_inline]] inline void softmax(std::span<const LabelGroup> groups, std::span<const std::uint32_t> voxels) {
  const auto full = [](const LabelGroup& group) { return group.columns * sizeof(float) == sizeof(Most); };
  for (const std::size_t i : voxels) {
    Lanes most;
    load_lanes(groups[0].rows + i * groups[0].stride, most);
    for (const LabelGroup& group : groups) full(group) ? find_highest<Most>(group, i, most) : find_highest<Lanes>(group, i, most);
    spread_highest(most);
    Lanes sums = {};
    for (const LabelGroup& group : groups) {
      full(group) ? raise<Most>(group, i, most[0], sums) : raise<Lanes>(group, i, most[0], sums);
    }
    spread_sum(sums);
    const float share = 1.0F / sums[0];
    for (const LabelGroup& group : groups) full(group) ? scale<Most>(group, i, share) : scale<Lanes>(group, i, share);
  }
}

PANOPTIC_CLONES
void softmax_rows(std::span<const LabelGroup> groups, std::span<const std::uint32_t> voxels) { softmax<Lanes>(groups, voxels); }
PANOPTIC_WIDE
void softmax_rows_wide(std::span<const LabelGroup> groups, std::span<const std::uint32_t> voxels) {
  softmax<WideLanes>(groups, voxels);
}

}  // namespace kernels

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
      head_start_(graph.size()) {
  PANOPTIC_ASSERT(graph.size() > 0 && graph.label_count > 0 && graph.all_labels >= graph.label_count);
  const std::size_t columns = (graph.label_count + kLanes - 1) / kLanes * kLanes;
  float* rows = scratch_.rows.make_room(graph.size() * columns);
  normalise_kernels();
  set_head_starts();
  is_label_.assign(columns, 0.0F);
  std::fill_n(is_label_.begin(), graph.label_count, 1.0F);
  add_chunks(columns, rows);
  ranges_.run(graph.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t> voxels(end - begin);
    std::iota(voxels.begin(), voxels.end(), static_cast<std::uint32_t>(begin));
    for (const Chunk& chunk : chunks_) {
      const auto width = static_cast<std::size_t>(chunk.width);
      std::fill(chunk.rows + begin * width, chunk.rows + end * width, 0.0F);
    }
    normalise_rows(voxels);
  });
}

// As few chunks as possible, as equal as possible: most of the time goes by rows, not by labels.
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
    kernels::combine_rows({voxels, sums, color_sums, color_filter_.cluster_of().data(), color_norm_.data(), grid_norm_.data(),
                           settings_.w1, settings_.w2, chunk.rows},
                          chunk.width);
    if (last) normalise_rows(voxels);
  };
  grid_filter_.apply({chunk.rows, width, grid_norm_.data()}, chunk.width, scratch_.grid, ranges_, take);
}

void MeanField::normalise_rows(std::span<const std::uint32_t> voxels) {
  for (const std::size_t i : voxels) {
    const std::uint16_t label = graph_.labels[i];
    if (label == CrfGraph::kOtherLabel) continue;
    *marginal_at(i, label) += head_start_[i];
  }
  has_wide_registers() ? kernels::softmax_rows_wide(groups_, voxels) : kernels::softmax_rows(groups_, voxels);
}

float* MeanField::marginal_at(std::size_t voxel, std::size_t label) const {
  const Column& column = columns_[label];
  return column.rows + voxel * column.stride;
}

float MeanField::marginal(std::size_t voxel, std::size_t label) const { return *marginal_at(voxel, label); }

MeanField::Best MeanField::best(std::size_t voxel) const {
  Best best{0, marginal(voxel, 0)};
  for (std::size_t label = 1; label < graph_.label_count; ++label) {
    const float probability = marginal(voxel, label);
    if (probability > best.probability) best = {static_cast<std::uint16_t>(label), probability};
  }
  return best;
}

std::size_t MeanField::memory_bytes() const {
  return 3 * graph_.size() * sizeof(float) + scratch_.memory_bytes() + grid_filter_.memory_bytes() + color_filter_.memory_bytes();
}

}  // namespace panoptic
