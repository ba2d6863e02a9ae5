// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A set of grid points within a box, one bit a point. After number_points() every point has a number: its rank in the order of
// (z, y, x). That makes a sparse grid an array, and finding a neighbour two loads and a count of bits.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace panoptic {

struct GridPoint {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;

  bool operator==(const GridPoint&) const = default;
};

// The cell that holds a point, where cells are cubes of `side` points and cell 0 begins at 0.
constexpr GridPoint cell_of(const GridPoint& p, std::int32_t side) {
  const auto along = [&](std::int32_t a) { return a / side - (a % side < 0 ? 1 : 0); };
  return {along(p.x), along(p.y), along(p.z)};
}

// std::popcount is a call into a library where the compiler may not assume a CPU with the instruction.
constexpr std::uint32_t count_bits(std::uint64_t bits) {
  if (bits == 0) return 0;
  bits -= (bits >> 1) & 0x5555555555555555U;
  bits = (bits & 0x3333333333333333U) + ((bits >> 2) & 0x3333333333333333U);
  bits = (bits + (bits >> 4)) & 0x0F0F0F0F0F0F0F0FU;
  return static_cast<std::uint32_t>((bits * 0x0101010101010101U) >> 56);
}

// The smallest box around points: its lowest corner and how many points it has along each axis.
struct GridBox {
  GridPoint origin;
  GridPoint size;
};
GridBox box_around(std::span<const GridPoint> points);

class BitGrid {
 public:
  explicit BitGrid(const GridBox& box);

  const GridBox& box() const { return box_; }
  // Row y, z of the box; coordinates count from the box's origin here and below.
  const std::uint64_t* row(std::int32_t y, std::int32_t z) const { return bits_.data() + row_offset(y, z); }

  void set(GridPoint p) { bits_[word(p)] |= bit(p); }
  bool contains(GridPoint p) const { return (bits_[word(p)] & bit(p)) != 0; }

  // True if there is a point from one place to another one of the same row, both included.
  bool any_between(GridPoint first, GridPoint last) const {
    const std::uint64_t from = ~(bit(first) - 1);
    const std::uint64_t to = bit(last) | (bit(last) - 1);
    const std::size_t w = word(first);
    const std::size_t end = word(last);
    if (w == end) return (bits_[w] & from & to) != 0;
    if ((bits_[w] & from) != 0 || (bits_[end] & to) != 0) return true;
    return std::any_of(bits_.begin() + static_cast<std::ptrdiff_t>(w) + 1, bits_.begin() + static_cast<std::ptrdiff_t>(end),
                       [](std::uint64_t word) { return word != 0; });
  }

  // Adds every point of the box within `radius` of a point of the set along one axis (0, 1, 2: x, y, z).
  void dilate(int axis, std::int32_t radius);
  void intersect(const BitGrid& other);  // REQUIRES the same box

  // Numbers the points and returns how many there are. Changes to the set afterwards make the numbers wrong.
  std::size_t number_points();
  // The number of points before this place.
  std::uint32_t rank(GridPoint p) const {
    const std::size_t w = word(p);
    return ranks_[w] + count_bits(bits_[w] & (bit(p) - 1));
  }
  std::uint32_t count_row(std::int32_t y, std::int32_t z) const {
    std::uint32_t count = 0;
    for (std::size_t w = 0; w < words_per_row_; ++w) count += count_bits(row(y, z)[w]);
    return count;
  }
  // body(x) for every point of a row, in their order.
  template <typename Body>
  void for_each_in_row(std::int32_t y, std::int32_t z, const Body& body) const {
    const std::uint64_t* words = row(y, z);
    for (std::size_t w = 0; w < words_per_row_; ++w) {
      for (std::uint64_t bits = words[w]; bits != 0; bits &= bits - 1) {
        body(static_cast<std::int32_t>(64 * w) + std::countr_zero(bits));
      }
    }
  }

 private:
  static std::uint64_t bit(GridPoint p) { return std::uint64_t{1} << (p.x & 63); }
  std::size_t row_offset(std::int32_t y, std::int32_t z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(box_.size.y) + static_cast<std::size_t>(y)) * words_per_row_;
  }
  std::size_t word(GridPoint p) const { return row_offset(p.y, p.z) + static_cast<std::size_t>(p.x >> 6); }
  void spread(int axis, std::int32_t distance);

  GridBox box_;
  std::size_t words_per_row_;
  std::vector<std::uint64_t> bits_;
  std::vector<std::uint32_t> ranks_;  // by word: points before it
};

}  // namespace panoptic
