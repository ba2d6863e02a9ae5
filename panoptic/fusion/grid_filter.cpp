// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/grid_filter.h"

#include <algorithm>
#include <cmath>

#include "panoptic/base/clones.h"
#include "panoptic/base/error.h"
#include "panoptic/fusion/grid_lines.h"
#include "panoptic/fusion/lanes.h"

namespace panoptic {
namespace {

constexpr std::size_t kAhead = 32;  // rows that are fetched before they are needed
// A sum of up to this many values is taken one by one, a longer one as pairs at the same distance: half the products.
constexpr std::ptrdiff_t kFew = 12;
constexpr std::size_t kGrain = 4;  // slices that are worked together

// Rows that only the thread which writes them reads: kept, because what is taken anew for every slice costs as much as the sums.
struct ThreadRows {
  FloatRows line;
  FloatRows slice;
};

ThreadRows& thread_rows() {
  thread_local ThreadRows rows;
  return rows;
}

}  // namespace

// External linkage on purpose: GCC's target_clones need it.
namespace kernels {

struct LineWork {
  const GridLines* lines;
  const float* middle_tap;  // Laid tells how far they go
  std::ptrdiff_t radius;
  ScaledRows in;
  float* line;  // room for the longest stretch with two radii at either end
  float* out;
};

void filter_lines_8(const LineWork& work);
void filter_lines_16(const LineWork& work);
void filter_lines_16_wide(const LineWork& work);

// Reads the values of a stretch without gaps; returns its length.
template <typename Row>
[[gnu::always_inline]] inline std::ptrdiff_t lay_out(const LineWork& work, std::size_t first, std::size_t past, float* to) {
  constexpr std::size_t kWidth = sizeof(Row) / sizeof(float);
  const LinePlace* places = work.lines->ins.data();
  const std::size_t last = work.lines->ins.size() - 1;
  Row row{};
  std::int32_t at = 0;
  for (; first < past; ++first) {
    __builtin_prefetch(work.in.row(places[first + kAhead < last ? first + kAhead : last].row));
    row.clear();
    for (; at < places[first].at; ++at) row.store(to + static_cast<std::size_t>(at) * kWidth);
    row.load(work.in.row(places[first].row));
    if (work.in.scale != nullptr) row.scale(work.in.scale[places[first].row]);
    row.store(to + static_cast<std::size_t>(at) * kWidth);
    ++at;
  }
  return at;
}

// A stretch as it is laid out, with two radii of zeros at either end, and what sums are made with.
struct Laid {
  const float* start;
  std::ptrdiff_t length;
  const float* middle_tap;  // up to a place beyond the radius on either side
  std::ptrdiff_t radius;

  [[gnu::always_inline]] std::ptrdiff_t low(std::ptrdiff_t at) const { return at > radius ? at - radius : 0; }
  [[gnu::always_inline]] std::ptrdiff_t high(std::ptrdiff_t at) const { return at + radius < length ? at + radius + 1 : length; }
  // Are few values within reach?
  [[gnu::always_inline]] bool few(std::ptrdiff_t at) const { return high(at) - low(at) <= kFew; }
};

template <typename Row>
[[gnu::always_inline]] inline Row sum_at(const Laid& laid, std::ptrdiff_t at) {
  constexpr std::ptrdiff_t kWidth = sizeof(Row) / sizeof(float);
  Row sum{};
  if (laid.few(at)) {
    for (std::ptrdiff_t k = laid.low(at); k < laid.high(at); ++k) {
      sum.add(laid.middle_tap[k - at], Row::at(laid.start + k * kWidth));
    }
    return sum;
  }
  const float* here = laid.start + at * kWidth;
  sum.load(here);
  sum.scale(laid.middle_tap[0]);
  for (std::ptrdiff_t k = 1; k <= laid.radius; ++k) {
    sum.add(laid.middle_tap[k], Row::at(here - k * kWidth), Row::at(here + k * kWidth));
  }
  return sum;
}

// The same bits for a place and the next one, with half the reads. REQUIRES few values within reach of both, or many of both.
template <typename Row>
[[gnu::always_inline]] inline void sum_two(const Laid& laid, std::ptrdiff_t at, Row& sum, Row& next) {
  constexpr std::ptrdiff_t kWidth = sizeof(Row) / sizeof(float);
  if (laid.few(at)) {
    for (std::ptrdiff_t k = laid.low(at); k < laid.high(at + 1); ++k) {
      const Row row = Row::at(laid.start + k * kWidth);
      sum.add(laid.middle_tap[k - at], row);
      next.add(laid.middle_tap[k - at - 1], row);
    }
    return;
  }
  const float* here = laid.start + at * kWidth;
  Row low = sum = Row::at(here);
  Row high = next = Row::at(here + kWidth);
  sum.scale(laid.middle_tap[0]);
  next.scale(laid.middle_tap[0]);
  for (std::ptrdiff_t k = 1; k <= laid.radius; ++k) {
    const Row lower = Row::at(here - k * kWidth);
    const Row higher = Row::at(here + (k + 1) * kWidth);
    sum.add(laid.middle_tap[k], lower, high);
    next.add(laid.middle_tap[k], low, higher);
    low = lower;
    high = higher;
  }
}

template <typename Row>
[[gnu::always_inline]] inline void filter_lines(const LineWork& work) {
  constexpr std::size_t kWidth = sizeof(Row) / sizeof(float);
  const std::size_t margin = 2 * static_cast<std::size_t>(work.radius) * kWidth;
  float* const start = work.line + margin;
  Laid laid{start, 0, work.middle_tap, work.radius};
  std::fill(work.line, start, 0.0F);
  const LinePlace* outs = work.lines->outs.data();
  const auto to = [&](const LinePlace& place) { return work.out + std::size_t{place.row} * kWidth; };
  std::size_t in = 0;
  std::size_t out = 0;
  for (const GridLines::Stretch stretch : work.lines->stretches) {
    laid.length = lay_out<Row>(work, in, stretch.ins_end, start);
    in = stretch.ins_end;
    if (laid.length > kFew) {
      float* const end = start + static_cast<std::size_t>(laid.length) * kWidth;
      std::fill(end, end + margin, 0.0F);
    }
    while (out < stretch.outs_end) {
      const std::ptrdiff_t at = outs[out].at;
      if (out + 1 < stretch.outs_end && outs[out + 1].at == at + 1 && laid.few(at) == laid.few(at + 1)) {
        Row sum{};
        Row next{};
        sum_two(laid, at, sum, next);
        sum.store(to(outs[out]));
        next.store(to(outs[out + 1]));
        out += 2;
      } else {
        sum_at<Row>(laid, at).store(to(outs[out]));
        ++out;
      }
    }
  }
}

PANOPTIC_CLONES void filter_lines_8(const LineWork& work) { filter_lines<LaneRow<8>>(work); }
PANOPTIC_CLONES void filter_lines_16(const LineWork& work) { filter_lines<LaneRow<16>>(work); }
PANOPTIC_WIDE void filter_lines_16_wide(const LineWork& work) { filter_lines<LaneRow<16, WideLanes>>(work); }

}  // namespace kernels

GridFilter::GridFilter(std::span<const GridPoint> points, float sigma, const Ranges& ranges) : size_(points.size()) {
  const auto radius = static_cast<std::int32_t>(std::ceil(kTruncation * sigma));
  taps_.push_back(0);
  for (std::int32_t k = -radius; k <= radius; ++k) {
    const double share = static_cast<double>(k) / sigma;
    taps_.push_back(static_cast<float>(std::exp(-0.5 * share * share)));
  }
  taps_.push_back(0);
  const GridPlaces places = find_places(points, radius);
  const GridPoint size = places.points.box().size;
  slices_.resize(static_cast<std::size_t>(size.z));
  last_.resize(static_cast<std::size_t>(size.y));
  ranges.run(slices_.size() + last_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (i < slices_.size()) {
        const auto z = static_cast<std::int32_t>(i);
        slices_[i] = {first_lines(places, z, radius), middle_lines(places, z, radius), 0};
        slices_[i].places = slices_[i].first.outs.size();
      } else {
        last_[i - slices_.size()] = last_lines(places, static_cast<std::int32_t>(i - slices_.size()), radius);
      }
    }
  });
  for (const Slice& slice : slices_) {
    places_first_ += slice.places;
    places_middle_ += slice.middle.outs.size();
  }
}

void GridFilter::apply(const ScaledRows& in, float* out, RowWidth row_width, GridScratch& scratch, const Ranges& ranges) const {
  const auto width = static_cast<std::size_t>(row_width);
  const auto filter_lines = row_width == RowWidth::k8 ? kernels::filter_lines_8
                            : has_wide_registers()    ? kernels::filter_lines_16_wide
                                                      : kernels::filter_lines_16;
  const float* middle_tap = taps_.data() + taps_.size() / 2;
  const auto radius = static_cast<std::ptrdiff_t>(taps_.size() / 2) - 1;
  const auto room = [&](std::size_t longest) { return (longest + 4 * static_cast<std::size_t>(radius)) * width; };
  float* between = scratch.rows.make_room(places_middle_ * width);
  ranges.run(slices_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    ThreadRows& rows = thread_rows();
    for (std::size_t i = begin; i < end; ++i) {
      const Slice& slice = slices_[i];
      float* line = rows.line.make_room(room(std::max(slice.first.longest, slice.middle.longest)));
      float* places = rows.slice.make_room(slice.places * width);
      filter_lines({&slice.first, middle_tap, radius, in, line, places});
      filter_lines({&slice.middle, middle_tap, radius, {places, width, nullptr}, line, between});
    }
  });
  ranges.run(last_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      float* line = thread_rows().line.make_room(room(last_[i].longest));
      filter_lines({&last_[i], middle_tap, radius, {between, width, nullptr}, line, out});
    }
  });
}

std::size_t GridFilter::memory_bytes() const {
  std::size_t bytes = 0;
  for (const Slice& slice : slices_) bytes += slice.first.memory_bytes() + slice.middle.memory_bytes();
  for (const GridLines& lines : last_) bytes += lines.memory_bytes();
  return bytes;
}

}  // namespace panoptic
