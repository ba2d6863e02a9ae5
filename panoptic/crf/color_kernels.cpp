// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/crf/color_kernels.h"

#include "panoptic/base/clones.h"
#include "panoptic/base/lanes.h"
#include "panoptic/crf/fast_exp.h"

#ifdef PANOPTIC_HAS_WIDE
#include <immintrin.h>
#endif

namespace panoptic::kernels {

constexpr std::size_t kAhead = 16;      // rows that are fetched before they are needed
constexpr std::size_t kCacheLine = 16;  // floats

// External linkage on purpose: GCC's target_clones need it.
void sum_members_8(const MemberSums& work);
void sum_members_16(const MemberSums& work);
void sum_members_24(const MemberSums& work);
void sum_members_32(const MemberSums& work);
void sum_members_16_wide(const MemberSums& work);
void sum_members_24_wide(const MemberSums& work);
void sum_members_32_wide(const MemberSums& work);
void sum_pairs_8(const PairSums& work);
void sum_pairs_16(const PairSums& work);
void sum_pairs_24(const PairSums& work);
void sum_pairs_32(const PairSums& work);
void sum_pairs_16_wide(const PairSums& work);
void sum_pairs_24_wide(const PairSums& work);
void sum_pairs_32_wide(const PairSums& work);

std::size_t keep_near(const PairWork& work);
std::size_t keep_near_wide(const PairWork& work);
void weigh_pairs(const PairWork& work, std::size_t count);
void weigh_pairs_wide(const PairWork& work, std::size_t count);

template <typename Part>
[[gnu::always_inline]] inline void square_differences(const PairWork& work, std::size_t i, Part& squares) {
  squares = Part{};
  for (std::size_t a = 0; a < 6; ++a) {
    Part difference;
    load_lanes(work.axes[a] + i, difference);
    difference -= work.center[a];
    squares += difference * difference;
  }
}

// The candidates that are near enough, and the negated squares of their differences, side by side. Which these are is as good as
// random: no branches.
PANOPTIC_CLONES
std::size_t keep_near(const PairWork& work) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < work.count; i += kLanes) {
    Lanes squares;
    square_differences(work, i, squares);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      work.near[count] = work.clusters[i + lane];
      work.weights[count] = -squares[lane];
      count += squares[lane] < work.farthest ? 1 : 0;
    }
  }
  return count;
}

#ifdef PANOPTIC_HAS_WIDE
PANOPTIC_WIDE
std::size_t keep_near_wide(const PairWork& work) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < work.count; i += 2 * kLanes) {
    WideLanes squares;
    square_differences(work, i, squares);
    const __mmask16 is_near = _mm512_cmp_ps_mask(squares, _mm512_set1_ps(work.farthest), _CMP_LT_OQ);
    const WideLanes negated = -squares;
    _mm512_storeu_ps(work.weights + count, _mm512_maskz_compress_ps(is_near, negated));
    _mm512_storeu_si512(work.near + count, _mm512_maskz_compress_epi32(is_near, _mm512_loadu_si512(work.clusters + i)));
    count += static_cast<std::size_t>(__builtin_popcount(is_near));
  }
  return count;
}
#else
std::size_t keep_near_wide(const PairWork& work) { return keep_near(work); }
#endif

template <typename Part>
[[gnu::always_inline]] inline void weigh(const PairWork& work, std::size_t count) {
  for (std::size_t i = 0; i < count; i += sizeof(Part) / sizeof(float)) {
    Part weights;
    load_lanes(work.weights + i, weights);
    fast_exp(weights);
    store_lanes(weights, work.weights + i);
  }
  for (std::size_t i = 0; i < count; ++i) work.found[i] = {work.near[i], work.weights[i]};
}

PANOPTIC_CLONES void weigh_pairs(const PairWork& work, std::size_t count) { weigh<Lanes>(work, count); }
PANOPTIC_WIDE void weigh_pairs_wide(const PairWork& work, std::size_t count) { weigh<WideLanes>(work, count); }

std::size_t find_pairs(const PairWork& work) {
  const bool wide = has_wide_registers();
  const std::size_t count = wide ? keep_near_wide(work) : keep_near(work);
  for (std::size_t lane = 0; lane < 2 * kLanes; ++lane) work.weights[count + lane] = 0;
  wide ? weigh_pairs_wide(work, count) : weigh_pairs(work, count);
  return count;
}

// add(i, sum) adds entry i of the list.
template <typename Row, typename Add>
[[gnu::always_inline]] inline void sum_rows(const RowSums& rows, const Add& add) {
  constexpr std::size_t kWidth = Row::kWidth;
  std::size_t i = rows.begin;
  float* out = rows.out;
  for (const std::uint32_t end : rows.ends) {
    Row sum{};
    for (; i < end; ++i) add(i, sum);
    sum.store(out);
    out += kWidth;
  }
}

template <typename Row>
[[gnu::always_inline]] inline void sum_members_of(const MemberSums& work) {
  sum_rows<Row>(
      work.rows, [&](std::size_t i, Row & sum) __attribute__((always_inline)) {
        const std::uint32_t voxel = work.members[i];
        const float* later = work.in.row(work.members[i + kAhead < work.count ? i + kAhead : i]);
        __builtin_prefetch(later);
        if constexpr (Row::kWidth > kCacheLine) __builtin_prefetch(later + Row::kWidth - 1);
        sum.add(work.in.scale == nullptr ? 1.0F : work.in.scale[voxel], Row::at(work.in.row(voxel)));
      });
}

template <typename Row>
[[gnu::always_inline]] inline void sum_pairs_of(const PairSums& work) {
  constexpr std::size_t kWidth = Row::kWidth;
  sum_rows<Row>(
      work.rows, [&](std::size_t i, Row & sum) __attribute__((always_inline)) {
        sum.add(work.pairs[i].weight, Row::at(work.in + std::size_t{work.pairs[i].cluster} * kWidth));
      });
}

PANOPTIC_CLONES void sum_members_8(const MemberSums& work) { sum_members_of<Row8>(work); }
PANOPTIC_CLONES void sum_members_16(const MemberSums& work) { sum_members_of<Row16>(work); }
PANOPTIC_CLONES void sum_members_24(const MemberSums& work) { sum_members_of<Row24>(work); }
PANOPTIC_CLONES void sum_members_32(const MemberSums& work) { sum_members_of<Row32>(work); }
PANOPTIC_WIDE void sum_members_16_wide(const MemberSums& work) { sum_members_of<WideRow16>(work); }
PANOPTIC_WIDE void sum_members_24_wide(const MemberSums& work) { sum_members_of<WideRow24>(work); }
PANOPTIC_WIDE void sum_members_32_wide(const MemberSums& work) { sum_members_of<WideRow32>(work); }
PANOPTIC_CLONES void sum_pairs_8(const PairSums& work) { sum_pairs_of<Row8>(work); }
PANOPTIC_CLONES void sum_pairs_16(const PairSums& work) { sum_pairs_of<Row16>(work); }
PANOPTIC_CLONES void sum_pairs_24(const PairSums& work) { sum_pairs_of<Row24>(work); }
PANOPTIC_CLONES void sum_pairs_32(const PairSums& work) { sum_pairs_of<Row32>(work); }
PANOPTIC_WIDE void sum_pairs_16_wide(const PairSums& work) { sum_pairs_of<WideRow16>(work); }
PANOPTIC_WIDE void sum_pairs_24_wide(const PairSums& work) { sum_pairs_of<WideRow24>(work); }
PANOPTIC_WIDE void sum_pairs_32_wide(const PairSums& work) { sum_pairs_of<WideRow32>(work); }

void sum_members(const MemberSums& work, RowWidth width) {
  const bool wide = has_wide_registers();
  switch (width) {
    case RowWidth::k8:
      return sum_members_8(work);
    case RowWidth::k16:
      return wide ? sum_members_16_wide(work) : sum_members_16(work);
    case RowWidth::k24:
      return wide ? sum_members_24_wide(work) : sum_members_24(work);
    case RowWidth::k32:
      return wide ? sum_members_32_wide(work) : sum_members_32(work);
  }
}

void sum_pairs(const PairSums& work, RowWidth width) {
  const bool wide = has_wide_registers();
  switch (width) {
    case RowWidth::k8:
      return sum_pairs_8(work);
    case RowWidth::k16:
      return wide ? sum_pairs_16_wide(work) : sum_pairs_16(work);
    case RowWidth::k24:
      return wide ? sum_pairs_24_wide(work) : sum_pairs_24(work);
    case RowWidth::k32:
      return wide ? sum_pairs_32_wide(work) : sum_pairs_32(work);
  }
}

}  // namespace panoptic::kernels
