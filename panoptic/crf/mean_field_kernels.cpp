// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/crf/mean_field_kernels.h"

#include <cstring>

#include "panoptic/base/clones.h"
#include "panoptic/base/lanes.h"
#include "panoptic/crf/fast_exp.h"

namespace panoptic::kernels {

constexpr std::size_t kAhead = 8;       // rows that are fetched before they are needed
constexpr std::size_t kCacheLine = 16;  // floats
constexpr float kLowest = -3e38F;

// External linkage on purpose: GCC's target_clones need it.
void combine_8(const MessageWork& work);
void combine_16(const MessageWork& work);
void combine_24(const MessageWork& work);
void combine_32(const MessageWork& work);
void softmax_lanes(const MarginalWork& work, std::span<const std::uint32_t> voxels);
void softmax_wide(const MarginalWork& work, std::span<const std::uint32_t> voxels);
void renew_8(const MessageWork& messages, const MarginalWork& marginals);
void renew_16(const MessageWork& messages, const MarginalWork& marginals);
void renew_24(const MessageWork& messages, const MarginalWork& marginals);
void renew_32(const MessageWork& messages, const MarginalWork& marginals);
void renew_16_wide(const MessageWork& messages, const MarginalWork& marginals);
void renew_24_wide(const MessageWork& messages, const MarginalWork& marginals);
void renew_32_wide(const MessageWork& messages, const MarginalWork& marginals);

// w1 and w2 with the norms of voxel k of the list; what a voxel's own marginals have in the sums.
struct Factors {
  float color;
  float grid;
  float own;
};
[[gnu::always_inline]] inline Factors factors_of(const MessageWork& work, std::size_t i) {
  const float color = work.w1 * work.color_norm[i];
  const float grid = work.w2 * work.grid_norm[i];
  return {color, grid, color * work.color_norm[i] + grid * work.grid_norm[i]};
}

template <std::size_t Width>
[[gnu::always_inline]] inline void fetch_later(const MessageWork& work, std::size_t k) {
  const std::size_t last = work.voxels.size() - 1;
  const std::size_t voxel = work.voxels[k + kAhead < last ? k + kAhead : last];
  const float* const rows = work.rows;
  for (const float* later : {rows + voxel * Width, work.color_sums + std::size_t{work.cluster_of[voxel]} * Width}) {
    __builtin_prefetch(later);
    if constexpr (Width > kCacheLine) __builtin_prefetch(later + Width - 1);
  }
}

template <std::size_t Width>
[[gnu::always_inline]] inline void combine(const MessageWork& work) {
  const float* grid = work.grid_sums;
  for (std::size_t k = 0; k < work.voxels.size(); ++k) {
    fetch_later<Width>(work, k);
    const std::size_t i = work.voxels[k];
    const Factors factors = factors_of(work, i);
    const float* color = work.color_sums + std::size_t{work.cluster_of[i]} * Width;
    float* row = work.rows + i * Width;
    for (std::size_t c = 0; c < Width; ++c) row[c] = factors.color * color[c] + factors.grid * grid[c] - factors.own * row[c];
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

// The level and the share that follow from the highest logit and the sum of a voxel. Logits are taken relative to the highest
// one, so that the exponential of a label without a column is `level`; the marginals are (exponential - level) * share.
[[gnu::always_inline]] inline float level_below(float most, float absent) { return absent > 0 ? fast_exp(-most) : 0.0F; }

template <typename Part>
[[gnu::always_inline]] inline void raise(Part& value, const float* is_label, float most, Lanes& sums) {
  Part mask;
  load_lanes(is_label, mask);
  value -= most;
  fast_exp(value);
  value *= mask;
  add_to(sums, value);
}
template <typename Part>
[[gnu::always_inline]] inline void scale(Part& value, const float* is_label, float level, float share) {
  Part mask;
  load_lanes(is_label, mask);
  value = (value - level * mask) * share;
}

template <typename Part>
[[gnu::always_inline]] inline void find_highest_in(const ColumnGroup& group, std::size_t i, Lanes& most) {
  Part logits;
  load_lanes(group.rows + i * group.stride, logits);
  take_highest(most, logits);
}
template <typename Part>
[[gnu::always_inline]] inline void raise_in(const ColumnGroup& group, std::size_t i, float most, Lanes& sums) {
  Part value;
  load_lanes(group.rows + i * group.stride, value);
  raise(value, group.is_label, most, sums);
  store_lanes(value, group.rows + i * group.stride);
}
template <typename Part>
[[gnu::always_inline]] inline void scale_in(const ColumnGroup& group, std::size_t i, float level, float share) {
  Part value;
  load_lanes(group.rows + i * group.stride, value);
  scale(value, group.is_label, level, share);
  store_lanes(value, group.rows + i * group.stride);
}

// `Most` values of a group at once if it has so many.
template <typename Most>
[[gnu::always_inline]] inline void softmax(const MarginalWork& work, std::span<const std::uint32_t> voxels) {
  const auto full = [](const ColumnGroup& group) { return group.columns * sizeof(float) == sizeof(Most); };
  for (const std::size_t i : voxels) {
    Lanes most = Lanes{} + (work.absent > 0 ? 0.0F : kLowest);
    for (const ColumnGroup& group : work.groups) {
      full(group) ? find_highest_in<Most>(group, i, most) : find_highest_in<Lanes>(group, i, most);
    }
    spread_highest(most);
    Lanes sums = {};
    for (const ColumnGroup& group : work.groups) {
      full(group) ? raise_in<Most>(group, i, most[0], sums) : raise_in<Lanes>(group, i, most[0], sums);
    }
    spread_sum(sums);
    const float level = level_below(most[0], work.absent);
    const float share = 1.0F / (sums[0] + work.absent * level);
    for (const ColumnGroup& group : work.groups) {
      full(group) ? scale_in<Most>(group, i, level, share) : scale_in<Lanes>(group, i, level, share);
    }
  }
}

PANOPTIC_CLONES
void softmax_lanes(const MarginalWork& work, std::span<const std::uint32_t> voxels) { softmax<Lanes>(work, voxels); }
PANOPTIC_WIDE
void softmax_wide(const MarginalWork& work, std::span<const std::uint32_t> voxels) { softmax<WideLanes>(work, voxels); }

void softmax_rows(const MarginalWork& work, std::span<const std::uint32_t> voxels) {
  std::size_t width = 0;
  for (const ColumnGroup& group : work.groups) {
    for (const std::size_t i : voxels) {
      const auto column = static_cast<std::size_t>(work.own_column[i]) - width;  // huge for none and for one before
      if (column < group.columns) group.rows[i * group.stride + column] += work.head_start[i];
    }
    width += group.columns;
  }
  has_wide_registers() ? softmax_wide(work, voxels) : softmax_lanes(work, voxels);
}

// The parts of a row one after the other, each with the number of its first column.
template <std::size_t At = 0, typename Body>
[[gnu::always_inline]] inline void for_each_part(NoLanes&, const Body&) {}
template <std::size_t At = 0, typename First, typename Rest, typename Body>
[[gnu::always_inline]] inline void for_each_part(LaneRow<First, Rest>& row, const Body& body) {
  body(row.first, At);
  for_each_part<At + LaneRow<First, Rest>::kFirst>(row.rest, body);
}

// Adds to one column: the numbers of the columns are compared, because a branch would be taken at random.
template <typename Part>
[[gnu::always_inline]] inline void add_at(Part& part, std::int32_t column, float value) {
  using Integers [[gnu::vector_size(sizeof(Part))]] = std::int32_t;
  constexpr std::int32_t kNumbers[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  Integers numbers;
  std::memcpy(&numbers, kNumbers, sizeof numbers);
  part += numbers == column ? Part{} + value : Part{};
}

template <typename Row>
[[gnu::always_inline]] inline void renew(const MessageWork& messages, const MarginalWork& marginals) {
  constexpr std::size_t kWidth = Row::kWidth;
  const float* is_label = marginals.groups[0].is_label;
  const float* grid = messages.grid_sums;
  for (std::size_t k = 0; k < messages.voxels.size(); ++k, grid += kWidth) {
    fetch_later<kWidth>(messages, k);
    const std::size_t i = messages.voxels[k];
    const Factors factors = factors_of(messages, i);
    Row row = Row::at(messages.color_sums + std::size_t{messages.cluster_of[i]} * kWidth);
    row.scale(factors.color);
    row.add(factors.grid, Row::at(grid));
    row.add(-factors.own, Row::at(messages.rows + i * kWidth));
    Lanes most = Lanes{} + (marginals.absent > 0 ? 0.0F : kLowest);
    const std::int32_t own = marginals.own_column[i];
    const float head_start = marginals.head_start[i];
    for_each_part(
        row, [&](auto& part, std::size_t at) __attribute__((always_inline)) {
          add_at(part, own - static_cast<std::int32_t>(at), head_start);
          take_highest(most, part);
        });
    spread_highest(most);
    Lanes sums = {};
    for_each_part(
        row, [&](auto& part, std::size_t at) __attribute__((always_inline)) { raise(part, is_label + at, most[0], sums); });
    spread_sum(sums);
    const float level = level_below(most[0], marginals.absent);
    const float share = 1.0F / (sums[0] + marginals.absent * level);
    for_each_part(
        row, [&](auto& part, std::size_t at) __attribute__((always_inline)) { scale(part, is_label + at, level, share); });
    row.store(messages.rows + i * kWidth);
  }
}

PANOPTIC_CLONES void renew_8(const MessageWork& messages, const MarginalWork& marginals) { renew<Row8>(messages, marginals); }
PANOPTIC_CLONES void renew_16(const MessageWork& messages, const MarginalWork& marginals) { renew<Row16>(messages, marginals); }
PANOPTIC_CLONES void renew_24(const MessageWork& messages, const MarginalWork& marginals) { renew<Row24>(messages, marginals); }
PANOPTIC_CLONES void renew_32(const MessageWork& messages, const MarginalWork& marginals) { renew<Row32>(messages, marginals); }
PANOPTIC_WIDE void renew_16_wide(const MessageWork& messages, const MarginalWork& marginals) {
  renew<WideRow16>(messages, marginals);
}
PANOPTIC_WIDE void renew_24_wide(const MessageWork& messages, const MarginalWork& marginals) {
  renew<WideRow24>(messages, marginals);
}
PANOPTIC_WIDE void renew_32_wide(const MessageWork& messages, const MarginalWork& marginals) {
  renew<WideRow32>(messages, marginals);
}

void renew_rows(const MessageWork& messages, const MarginalWork& marginals, RowWidth width) {
  const bool wide = has_wide_registers();
  switch (width) {
    case RowWidth::k8:
      return renew_8(messages, marginals);
    case RowWidth::k16:
      return wide ? renew_16_wide(messages, marginals) : renew_16(messages, marginals);
    case RowWidth::k24:
      return wide ? renew_24_wide(messages, marginals) : renew_24(messages, marginals);
    case RowWidth::k32:
      return wide ? renew_32_wide(messages, marginals) : renew_32(messages, marginals);
  }
}

}  // namespace panoptic::kernels
