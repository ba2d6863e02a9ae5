// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/crf/bit_grid.h"

#include <algorithm>

#include "panoptic/error.h"

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

// The same with whole words.
void spread_words(std::uint64_t* __restrict words, const std::uint64_t* __restrict copy, std::size_t count, std::size_t shift) {
  if (shift >= count) return;
  for (std::size_t w = 0; w < count - shift; ++w) words[w] |= copy[w + shift];
  for (std::size_t w = shift; w < count; ++w) words[w] |= copy[w - shift];
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
  const std::size_t rows = static_cast<std::size_t>(box_.size.y) * static_cast<std::size_t>(box_.size.z);
  const auto along = static_cast<std::size_t>(distance);
  if (axis == 0) {
    for (std::size_t w = 0; w < rows * words_per_row_; w += words_per_row_) {
      spread_row(bits_.data() + w, copy.data() + w, words_per_row_, along);
    }
    return;
  }
  // Rows along y follow each other, slices along z too: what is spread is a long stretch of words.
  const std::size_t slice = static_cast<std::size_t>(box_.size.y) * words_per_row_;
  const std::size_t stretch = axis == 1 ? slice : bits_.size();
  const std::size_t shift = axis == 1 ? along * words_per_row_ : along * slice;
  for (std::size_t w = 0; w < bits_.size(); w += stretch) spread_words(bits_.data() + w, copy.data() + w, stretch, shift);
}

void BitGrid::intersect(const BitGrid& other) {
  PANOPTIC_ASSERT(bits_.size() == other.bits_.size());
  for (std::size_t w = 0; w < bits_.size(); ++w) bits_[w] &= other.bits_[w];
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
