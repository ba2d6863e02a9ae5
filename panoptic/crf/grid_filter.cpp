// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/crf/grid_filter.h"

#include <algorithm>
#include <cmath>

#include "panoptic/base/clones.h"
#include "panoptic/base/lanes.h"
#include "panoptic/crf/grid_lines.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr std::size_t kAhead = 32;      // rows that are fetched before they are needed
constexpr std::size_t kCacheLine = 16;  // floats
// Sums whose places lie at most this far apart are taken together, so that a value is read once for all of them.
constexpr std::int32_t kSpan = 8;
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
  const float* middle_tap;  // 0 from beyond the radius up to kSpan farther
  std::ptrdiff_t radius;
  ScaledRows in;
  float* line;  // room for the longest stretch
  float* out;
};

void filter_lines_8(const LineWork& work);
void filter_lines_16(const LineWork& work);
void filter_lines_24(const LineWork& work);
void filter_lines_32(const LineWork& work);
void filter_lines_16_wide(const LineWork& work);
void filter_lines_24_wide(const LineWork& work);
void filter_lines_32_wide(const LineWork& work);

// Reads the values of a stretch without gaps; returns its length.
template <typename Row>
[[gnu::always_inline]] inline std::ptrdiff_t lay_out(const LineWork& work, std::size_t first, std::size_t past, float* to) {
  constexpr std::size_t kWidth = Row::kWidth;
  const LinePlace* places = work.lines->ins.data();
  const std::size_t last = work.lines->ins.size() - 1;
  const Row nothing;
  std::int32_t at = 0;
  for (; first < past; ++first) {
    const float* later = work.in.row(places[first + kAhead < last ? first + kAhead : last].row);
    __builtin_prefetch(later);
    if constexpr (kWidth > kCacheLine) __builtin_prefetch(later + kWidth - 1);
    for (; at < places[first].at; ++at) nothing.store(to + static_cast<std::size_t>(at) * kWidth);
    Row row = Row::at(work.in.row(places[first].row));
    if (work.in.scale != nullptr) row.scale(work.in.scale[places[first].row]);
    row.store(to + static_cast<std::size_t>(at) * kWidth);
    ++at;
  }
  return at;
}

// Sums at places one after the other. Where a value is out of reach of one of them, its tap is 0.
template <typename Row, std::size_t Count>
struct SumsAt {
  Row sum;
  const float* taps;
  SumsAt<Row, Count - 1> rest;

  [[gnu::always_inline]] SumsAt(const float* middle_tap, const LinePlace* outs)
      : taps(middle_tap - outs[0].at), rest(middle_tap, outs + 1) {}
  [[gnu::always_inline]] void add(std::ptrdiff_t at, const Row& row) {
    sum.add(taps[at], row);
    rest.add(at, row);
  }
  [[gnu::always_inline]] void store(float* out, const LinePlace* outs) const {
    sum.store(out + std::size_t{outs[0].row} * Row::kWidth);
    rest.store(out, outs + 1);
  }
};
template <typename Row>
struct SumsAt<Row, 0> {
  [[gnu::always_inline]] SumsAt(const float*, const LinePlace*) {}
  [[gnu::always_inline]] void add(std::ptrdiff_t, const Row&) {}
  [[gnu::always_inline]] void store(float*, const LinePlace*) const {}
};

// REQUIRES `Count` places within kSpan.
template <typename Row, std::size_t Count>
[[gnu::always_inline]] inline void sum_at(const LineWork& work, std::ptrdiff_t length, const LinePlace* outs) {
  const std::ptrdiff_t low = outs[0].at - work.radius;
  const std::ptrdiff_t high = outs[Count - 1].at + work.radius + 1;
  const std::ptrdiff_t past = high < length ? high : length;
  SumsAt<Row, Count> sums(work.middle_tap, outs);
  for (std::ptrdiff_t k = low > 0 ? low : 0; k < past; ++k) {
    sums.add(k, Row::at(work.line + static_cast<std::size_t>(k) * Row::kWidth));
  }
  sums.store(work.out, outs);
}

template <typename Row, std::size_t Most>
[[gnu::always_inline]] inline void filter_lines(const LineWork& work) {
  const LinePlace* outs = work.lines->outs.data();
  const auto together = [&](std::size_t first, std::size_t count, std::size_t end) __attribute__((always_inline)) {
    return first + count <= end && outs[first + count - 1].at - outs[first].at <= kSpan;
  };
  std::size_t in = 0;
  std::size_t out = 0;
  for (const GridLines::Stretch stretch : work.lines->stretches) {
    const std::ptrdiff_t length = lay_out<Row>(work, in, stretch.ins_end, work.line);
    in = stretch.ins_end;
    while (out < stretch.outs_end) {
      if (together(out, Most, stretch.outs_end)) {
        sum_at<Row, Most>(work, length, outs + out);
        out += Most;
      } else if (together(out, 2, stretch.outs_end)) {
        sum_at<Row, 2>(work, length, outs + out);
        out += 2;
      } else {
        sum_at<Row, 1>(work, length, outs + out);
        ++out;
      }
    }
  }
}

// Works on as many sums at a time as there are registers for.
PANOPTIC_CLONES void filter_lines_8(const LineWork& work) { filter_lines<Row8, 4>(work); }
PANOPTIC_CLONES void filter_lines_16(const LineWork& work) { filter_lines<Row16, 4>(work); }
PANOPTIC_CLONES void filter_lines_24(const LineWork& work) { filter_lines<Row24, 3>(work); }
PANOPTIC_CLONES void filter_lines_32(const LineWork& work) { filter_lines<Row32, 2>(work); }
PANOPTIC_WIDE void filter_lines_16_wide(const LineWork& work) { filter_lines<WideRow16, 4>(work); }
PANOPTIC_WIDE void filter_lines_24_wide(const LineWork& work) { filter_lines<WideRow24, 4>(work); }
PANOPTIC_WIDE void filter_lines_32_wide(const LineWork& work) { filter_lines<WideRow32, 4>(work); }

using LineFilter = void (*)(const LineWork&);

LineFilter line_filter(RowWidth width) {
  const bool wide = has_wide_registers();
  switch (width) {
    case RowWidth::k8:
      return filter_lines_8;
    case RowWidth::k16:
      return wide ? filter_lines_16_wide : filter_lines_16;
    case RowWidth::k24:
      return wide ? filter_lines_24_wide : filter_lines_24;
    case RowWidth::k32:
      break;
  }
  return wide ? filter_lines_32_wide : filter_lines_32;
}

}  // namespace kernels

GridFilter::GridFilter(std::span<const GridPoint> points, float sigma, const Ranges& ranges)
    : size_(points.size()), reach_(static_cast<std::int32_t>(std::ceil(kTruncation * sigma))) {
  const std::int32_t radius = reach_;
  taps_.assign(2 * static_cast<std::size_t>(radius + kSpan) + 1, 0.0F);
  for (std::int32_t k = -radius; k <= radius; ++k) {
    const double share = static_cast<double>(k) / sigma;
    taps_[static_cast<std::size_t>(k + radius + kSpan)] = static_cast<float>(std::exp(-0.5 * share * share));
  }
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

void GridFilter::apply(const ScaledRows& in, RowWidth row_width, GridScratch& scratch, const Ranges& ranges,
                       const Take& take) const {
  const auto width = static_cast<std::size_t>(row_width);
  const auto filter_lines = kernels::line_filter(row_width);
  const float* middle_tap = taps_.data() + taps_.size() / 2;
  float* between = scratch.rows.make_room(places_middle_ * width);
  ranges.run(slices_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    ThreadRows& rows = thread_rows();
    for (std::size_t i = begin; i < end; ++i) {
      const Slice& slice = slices_[i];
      float* line = rows.line.make_room(std::max(slice.first.longest, slice.middle.longest) * width);
      float* places = rows.slice.make_room(slice.places * width);
      filter_lines({&slice.first, middle_tap, reach_, in, line, places});
      filter_lines({&slice.middle, middle_tap, reach_, {places, width, nullptr}, line, between});
    }
  });
  ranges.run(last_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const LastLines& last = last_[i];
      if (last.points.empty()) continue;
      ThreadRows& rows = thread_rows();
      float* line = rows.line.make_room(last.lines.longest * width);
      float* sums = rows.slice.make_room(last.points.size() * width);
      filter_lines({&last.lines, middle_tap, reach_, {between, width, nullptr}, line, sums});
      take(last.points, sums);
    }
  });
}

std::size_t GridFilter::memory_bytes() const {
  std::size_t bytes = 0;
  for (const Slice& slice : slices_) bytes += slice.first.memory_bytes() + slice.middle.memory_bytes();
  for (const LastLines& last : last_) bytes += last.lines.memory_bytes() + last.points.capacity() * sizeof(std::uint32_t);
  return bytes;
}

}  // namespace panoptic
