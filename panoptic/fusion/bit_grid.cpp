// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/bit_grid.h"

#include <algorithm>

#include "panoptic/base/error.h"

namespace panoptic {
namespace {

// row |= row shifted by `distance` bits both ways, from a copy.
void spread_row(std::uint64_t* row, const std::uint64_t* copy, std::size_t words, std::size_t distance) {
  const std::size_t far = distance / 64;
  const auto near = static_cast<unsigned>(distance % 64);
  for (std::size_t w = 0; w < words; ++w) {
    std::uint64_t value = copy[w];
    if (w >= far) value |= copy[w - far] << near;
    if (near != 0 && w >= far + 1) value |= copy[w - far - 1] >> (64 - near);
    if (w + far < words) value |= copy[w + far] >> near;
    if (near != 0 && w + far + 1 < words) value |= copy[w + far + 1] << (64 - near);
    row[w] = value;
  }
}

}  // namespace

GridBox box_around(std::span<const GridPoint> points) {
  if (points.empty()) return {};
  GridPoint low = points[0];
  GridPoint high = points[0];
  for (const GridPoint& p : points) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  return {low, {high.x - low.x + 1, high.y - low.y + 1, high.z - low.z + 1}};
}

BitGrid::BitGrid(const GridBox& box)
    : box_(box),
      words_per_row_((static_cast<std::size_t>(box.size.x) + 63) / 64),
      bits_(words_per_row_ * static_cast<std::size_t>(box.size.y) * static_cast<std::size_t>(box.size.z), 0) {}

void BitGrid::dilate(int axis, std::int32_t radius) {
  // Each step doubles what is covered on either side. It could be tripled inside, but not where the box cuts one side off.
  for (std::int32_t reached = 0; reached < radius;) {
    const std::int32_t step = std::min(reached + 1, radius - reached);
    spread(axis, step);
    reached += step;
  }
}

void BitGrid::spread(int axis, std::int32_t distance) {
  const std::vector<std::uint64_t> copy = bits_;
  const std::int32_t ny = box_.size.y;
  const std::int32_t nz = box_.size.z;
  const auto add_row = [&](std::size_t to, std::size_t from) {
    for (std::size_t w = 0; w < words_per_row_; ++w) bits_[to + w] |= copy[from + w];
  };
  for (std::int32_t z = 0; z < nz; ++z) {
    for (std::int32_t y = 0; y < ny; ++y) {
      const std::size_t here = row_offset(y, z);
      if (axis == 0) {
        spread_row(bits_.data() + here, copy.data() + here, words_per_row_, static_cast<std::size_t>(distance));
      } else if (axis == 1) {
        if (y >= distance) add_row(here, row_offset(y - distance, z));
        if (y + distance < ny) add_row(here, row_offset(y + distance, z));
      } else {
        if (z >= distance) add_row(here, row_offset(y, z - distance));
        if (z + distance < nz) add_row(here, row_offset(y, z + distance));
      }
    }
  }
}

void BitGrid::intersect(const BitGrid& other) {
  PANOPTIC_ASSERT(bits_.size() == other.bits_.size());
  for (std::size_t w = 0; w < bits_.size(); ++w) bits_[w] &= other.bits_[w];
}

void BitGrid::unite(const BitGrid& other) {
  PANOPTIC_ASSERT(bits_.size() == other.bits_.size());
  for (std::size_t w = 0; w < bits_.size(); ++w) bits_[w] |= other.bits_[w];
}

std::size_t BitGrid::number_points() {
  ranks_.resize(bits_.size());
  std::uint32_t count = 0;
  for (std::size_t w = 0; w < bits_.size(); ++w) {
    ranks_[w] = count;
    count += count_bits(bits_[w]);
  }
  return count;
}

}  // namespace panoptic
