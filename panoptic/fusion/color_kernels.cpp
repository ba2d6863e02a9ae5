// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/color_kernels.h"

#include "panoptic/base/clones.h"
#include "panoptic/fusion/fast_exp.h"
#include "panoptic/fusion/lanes.h"

namespace panoptic::kernels {

// External linkage on purpose: GCC's target_clones need it.
void weigh_pairs(ClusterPair* pairs, std::size_t count);
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

void square_differences(const PairWork& work);

PANOPTIC_CLONES
void square_differences(const PairWork& work) {
  for (std::size_t i = 0; i < work.count; i += kLanes) {
    Lanes squares = {};
    for (std::size_t a = 0; a < 6; ++a) {
      Lanes difference;
      std::memcpy(&difference, work.axes[a] + i, sizeof difference);
      difference -= work.center[a];
      squares += difference * difference;
    }
    std::memcpy(work.squares + i, &squares, sizeof squares);
  }
}

PANOPTIC_CLONES
void weigh_pairs(ClusterPair* pairs, std::size_t count) {
  for (std::size_t i = 0; i < count; i += kLanes) {
    Lanes weight;
    for (std::size_t lane = 0; lane < kLanes; ++lane) weight[lane] = pairs[i + lane].weight;
    fast_exp(weight);
    for (std::size_t lane = 0; lane < kLanes; ++lane) pairs[i + lane].weight = weight[lane];
  }
}

std::size_t find_pairs(const PairWork& work) {
  square_differences(work);
  std::size_t count = 0;
  for (std::size_t i = 0; i < work.count; ++i) {  // which are near enough is as good as random: no branches
    work.found[count] = {work.clusters[i], -work.squares[i]};
    count += work.squares[i] < work.farthest ? 1 : 0;
  }
  for (std::size_t lane = 0; lane < kLanes; ++lane) work.found[count + lane] = {};
  weigh_pairs(work.found, count);
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
