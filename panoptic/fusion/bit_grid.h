// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A set of grid points within a box, one bit a point. After number_points() every point has a number: its rank in the order of
// (z, y, x). That makes a sparse grid an array, and finding a neighbour two loads and a count of bits.
#pragma once

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
  std::size_t words_per_row() const { return words_per_row_; }
  // Row y, z of the box; coordinates count from the box's origin here and below.
  const std::uint64_t* row(std::int32_t y, std::int32_t z) const { return bits_.data() + row_offset(y, z); }

  void set(GridPoint p) { bits_[word(p)] |= bit(p); }
  bool contains(GridPoint p) const { return (bits_[word(p)] & bit(p)) != 0; }

  // Adds every point of the box within `radius` of a point of the set along one axis (0, 1, 2: x, y, z).
  void dilate(int axis, std::int32_t radius);
  void intersect(const BitGrid& other);  // REQUIRES the same box
  void unite(const BitGrid& other);      // REQUIRES the same box

  // Numbers the points and returns how many there are. Changes to the set afterwards make the numbers wrong.
  std::size_t number_points();
  // How many points come before this place.
  std::uint32_t rank(GridPoint p) const {
    const std::size_t w = word(p);
    return ranks_[w] + static_cast<std::uint32_t>(std::popcount(bits_[w] & (bit(p) - 1)));
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
