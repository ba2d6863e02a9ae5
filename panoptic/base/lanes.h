// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Eight floats as one value. Sums over rows of labels are kept in these, because in arrays of floats the compiler keeps them in
// memory (three times slower). For use inside functions only: how such a value is passed depends on the instruction set.
#pragma once

#include <cstddef>
#include <cstring>

#include "panoptic/base/clones.h"

// Sixteen floats as one value are half again as fast where the CPU has registers for them; anywhere else GCC makes copies of
// them in memory. So code that uses WideLanes is a function of its own, for such a CPU alone.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && !defined(__SANITIZE_THREAD__) && \
    !defined(__SANITIZE_ADDRESS__)
#define PANOPTIC_HAS_WIDE
#define PANOPTIC_WIDE [[gnu::target("arch=x86-64-v4")]]
#else
#define PANOPTIC_WIDE
#endif

namespace panoptic {

inline constexpr std::size_t kLanes = 8;
using Lanes [[gnu::vector_size(32)]] = float;
using WideLanes [[gnu::vector_size(64)]] = float;

// True if functions marked PANOPTIC_WIDE may be called and are faster.
inline bool has_wide_registers() {
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__)
  return __builtin_cpu_supports("x86-64-v4") != 0;
#else
  return false;
#endif
}

// Load and store such values at floats of any alignment. A value is passed as an argument, for the reason above.
template <typename Part>
[[gnu::always_inline]] inline void load_lanes(const float* from, Part& part) {
  using Unaligned [[gnu::aligned(4), gnu::may_alias]] = Part;
  part = *reinterpret_cast<const Unaligned*>(from);
}
template <typename Part>
[[gnu::always_inline]] inline void store_lanes(const Part& part, float* to) {
  using Unaligned [[gnu::aligned(4), gnu::may_alias]] = Part;
  *reinterpret_cast<Unaligned*>(to) = part;
}

struct NoLanes {
  static constexpr std::size_t kWidth = 0;

  [[gnu::always_inline]] void load(const float*) {}
  [[gnu::always_inline]] void store(float*) const {}
  [[gnu::always_inline]] void scale(float) {}
  [[gnu::always_inline]] void add(float, const NoLanes&) {}
};

// A row of labels: some of them, and the rest as another row. A list and not an array: GCC keeps arrays of such values in memory,
// where every addition then waits for the one before it.
template <typename First, typename Rest = NoLanes>
struct LaneRow {
  static constexpr std::size_t kFirst = sizeof(First) / sizeof(float);
  static constexpr std::size_t kWidth = kFirst + Rest::kWidth;
  First first = {};
  [[no_unique_address]] Rest rest = {};

  [[gnu::always_inline]] void load(const float* from) {
    load_lanes(from, first);
    rest.load(from + kFirst);
  }
  [[gnu::always_inline]] void store(float* to) const {
    store_lanes(first, to);
    rest.store(to + kFirst);
  }
  [[gnu::always_inline]] void scale(float factor) {
    first *= factor;
    rest.scale(factor);
  }
  // += factor * row
  [[gnu::always_inline]] void add(float factor, const LaneRow& row) {
    first += factor * row.first;
    rest.add(factor, row.rest);
  }
  [[gnu::always_inline]] static LaneRow at(const float* from) {
    LaneRow row;
    row.load(from);
    return row;
  }
};

using Row8 = LaneRow<Lanes>;
using Row16 = LaneRow<Lanes, Row8>;
using Row24 = LaneRow<Lanes, Row16>;
using Row32 = LaneRow<Lanes, Row24>;
using WideRow16 = LaneRow<WideLanes>;
using WideRow24 = LaneRow<WideLanes, Row8>;
using WideRow32 = LaneRow<WideLanes, WideRow16>;

}  // namespace panoptic
