// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Eight floats as one value. Sums over rows of labels are kept in these, because in arrays of floats the compiler keeps them in
// memory (three times slower). For use inside functions only: how such a value is passed depends on the instruction set.
#pragma once

#include <cstddef>
#include <cstring>

#include "panoptic/base/clones.h"

// Sixteen floats as one value are half again as fast where the CPU has registers for them; anywhere else GCC makes copies of them
// in memory. So what uses WideLanes is a function of its own, for such a CPU alone.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && !defined(__SANITIZE_THREAD__) && \
    !defined(__SANITIZE_ADDRESS__)
#define PANOPTIC_WIDE [[gnu::target("arch=x86-64-v4")]]
#else
#define PANOPTIC_WIDE
#endif

namespace panoptic {

inline constexpr std::size_t kLanes = 8;
using Lanes [[gnu::vector_size(32)]] = float;
using WideLanes [[gnu::vector_size(64)]] = float;

// May functions marked PANOPTIC_WIDE be called, and are they faster?
inline bool has_wide_registers() {
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__)
  return __builtin_cpu_supports("x86-64-v4") != 0;
#else
  return false;
#endif
}

// A row of 8 or 16 labels, as one or more parts.
template <std::size_t Width, typename Part = Lanes>
struct LaneRow {
  static constexpr std::size_t kParts = Width * sizeof(float) / sizeof(Part);
  Part parts[kParts] = {};

  [[gnu::always_inline]] void clear() {
    for (Part& part : parts) part = Part{};
  }
  [[gnu::always_inline]] void load(const float* from) { std::memcpy(parts, from, sizeof parts); }
  [[gnu::always_inline]] void store(float* to) const { std::memcpy(to, parts, sizeof parts); }
  [[gnu::always_inline]] void scale(float factor) {
    for (Part& part : parts) part *= factor;
  }
  // += factor * row
  [[gnu::always_inline]] void add(float factor, const LaneRow& row) {
    for (std::size_t p = 0; p < kParts; ++p) parts[p] += factor * row.parts[p];
  }
  // += factor * (row + other row)
  [[gnu::always_inline]] void add(float factor, const LaneRow& row, const LaneRow& other) {
    for (std::size_t p = 0; p < kParts; ++p) parts[p] += factor * (row.parts[p] + other.parts[p]);
  }
  [[gnu::always_inline]] static LaneRow at(const float* from) {
    LaneRow row{};
    row.load(from);
    return row;
  }
};

}  // namespace panoptic
