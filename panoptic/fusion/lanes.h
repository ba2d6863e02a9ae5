// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Eight floats as one value. Sums over rows of labels are kept in these, because in arrays of floats the compiler keeps them in
// memory (three times slower). For use inside functions only: how such a value is passed depends on the instruction set.
#pragma once

#include <cstddef>
#include <cstring>

namespace panoptic {

inline constexpr std::size_t kLanes = 8;
using Lanes [[gnu::vector_size(32)]] = float;

// A row of 8 or 16 labels.
template <std::size_t Width>
struct LaneRow {
  using Values [[gnu::vector_size(Width * sizeof(float))]] = float;
  Values values = {};

  [[gnu::always_inline]] void clear() { values = Values{}; }
  [[gnu::always_inline]] void load(const float* from) { std::memcpy(&values, from, sizeof values); }
  [[gnu::always_inline]] void store(float* to) const { std::memcpy(to, &values, sizeof values); }
  [[gnu::always_inline]] void scale(float factor) { values *= factor; }
  // += factor * row
  [[gnu::always_inline]] void add(float factor, const float* row) {
    LaneRow other{};
    other.load(row);
    values += factor * other.values;
  }
  // += factor * (row + other row)
  [[gnu::always_inline]] void add(float factor, const float* row, const float* other_row) {
    LaneRow one{};
    LaneRow other{};
    one.load(row);
    other.load(other_row);
    values += factor * (one.values + other.values);
  }
};

}  // namespace panoptic
