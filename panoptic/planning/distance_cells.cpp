// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/distance_cells.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include "panoptic/error.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr std::uint8_t kNoneInRow = 255;
constexpr int kFarSquare = std::numeric_limits<int>::max() / 2;
constexpr double kMostCells = 1e9;  // seven bytes each

int square_or_far(std::uint16_t squared) { return squared == DistanceCells::kFar ? kFarSquare : squared; }
int square_of_row(std::uint8_t cells) { return cells == kNoneInRow ? kFarSquare : cells * cells; }

// The least of in[j] + (i - j)^2 for the places reach .. in.size() - reach - 1, which go to out[0], out[1] ...; kFar beyond
// reach.
void least_along(const std::vector<int>& in, int reach, std::vector<int>& out) {
  const int count = static_cast<int>(in.size()) - 2 * reach;
  out.resize(static_cast<std::size_t>(std::max(count, 0)));
  for (int i = 0; i < count; ++i) {
    const int* at = in.data() + i + reach;
    int best = *at;
    for (int k = 1; k <= reach && k * k < best; ++k) best = std::min(best, std::min(at[-k], at[k]) + k * k);
    out[static_cast<std::size_t>(i)] = best > reach * reach ? int{DistanceCells::kFar} : best;
  }
}

bool all_far(const std::vector<int>& in) {
  return std::all_of(in.begin(), in.end(), [](int value) { return value == kFarSquare; });
}

// The range of places whose input changed; empty if first > last.
struct Range {
  int first = std::numeric_limits<int>::max();
  int last = -1;

  void add(int place) {
    first = std::min(first, place);
    last = std::max(last, place);
  }
};

}  // namespace

std::size_t CellBox::count() const {
  return static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y()) * static_cast<std::size_t>(size.z());
}

bool CellBox::contains(const Cell& cell) const {
  return ((cell - low).array() >= 0).all() && ((cell - low).array() < size.array()).all();
}

bool CellBox::contains(const CellBox& other) const {
  return ((other.low - low).array() >= 0).all() && ((other.low + other.size - low - size).array() <= 0).all();
}

DistanceCells::DistanceCells(int reach) : reach_(reach) { PANOPTIC_ASSERT(reach >= 1 && reach <= kMostReach); }

void DistanceCells::cover(const CellBox& box) {
  if (box.count() == 0 || box_.contains(box)) return;
  Cell low = box.low;
  Cell high = box.low + box.size;
  if (box_.count() > 0) {
    low = low.cwiseMin(box_.low);
    high = high.cwiseMax(box_.low + box_.size);
  }
  constexpr int kFewestMore = 4;
  for (int a = 0; a < 3; ++a) {
    const int more = std::max(kFewestMore, (high[a] - low[a]) / 8);
    if (box_.count() == 0 || low[a] < box_.low[a]) low[a] -= more;
    if (box_.count() == 0 || high[a] > box_.low[a] + box_.size[a]) high[a] += more;
  }
  const Cell size = high - low;
  if (size.cast<double>().prod() > kMostCells) {
    throw Error(fmt::format("the map spans {} x {} x {} cells of the distance field, more than {:.0g}; plan on a part of it",
                            size.x(), size.y(), size.z(), kMostCells));
  }
  resize({low, size});
}

void DistanceCells::resize(const CellBox& box) {
  std::vector<std::uint16_t> members(box.count(), 0);
  const CellBox before = box_;
  members.swap(members_);
  box_ = box;
  along_x_.assign(box.count(), kNoneInRow);
  along_y_.assign(box.count(), kFar);
  result_.assign(box.count(), kFar);
  touched_.assign(box.count(), 0);
  slices_.assign(static_cast<std::size_t>(box.size.z()), {std::vector<std::uint8_t>(static_cast<std::size_t>(box.size.y()), 0)});
  for (std::size_t i = 0; i < members.size(); ++i) {
    if (members[i] == 0) continue;
    const auto width = static_cast<std::size_t>(before.size.x());
    const auto height = static_cast<std::size_t>(before.size.y());
    const Cell cell = before.low + Cell(static_cast<int>(i % width), static_cast<int>(i / width % height),
                                        static_cast<int>(i / width / height));
    members_[box_.index(cell)] = members[i];
    mark(cell);
  }
}

void DistanceCells::mark(const Cell& cell) {
  ChangedSlice& slice = slices_[static_cast<std::size_t>(cell.z() - box_.low.z())];
  slice.rows[static_cast<std::size_t>(cell.y() - box_.low.y())] = 1;
  slice.any = true;
}

void DistanceCells::add(const Cell& cell) {
  if (members_[box_.index(cell)]++ == 0) mark(cell);
}

void DistanceCells::remove(const Cell& cell) {
  PANOPTIC_ASSERT(holds(cell));
  if (--members_[box_.index(cell)] == 0) mark(cell);
}

std::size_t DistanceCells::update() {
  if (std::none_of(slices_.begin(), slices_.end(), [](const ChangedSlice& slice) { return slice.any; })) return 0;
  parallel_for(slices_.size(), [&](std::size_t z) {
    if (slices_[z].any) update_slice(static_cast<int>(z));
  });
  std::vector<std::size_t> changed(static_cast<std::size_t>(box_.size.y()), 0);
  parallel_for(changed.size(), [&](std::size_t y) { changed[y] = update_along_z(static_cast<int>(y)); });
  for (ChangedSlice& slice : slices_) slice.any = false;
  return std::accumulate(changed.begin(), changed.end(), std::size_t{0});
}

// The distances along x of the changed rows, then along y of the columns that they changed.
void DistanceCells::update_slice(int z) {
  const auto width = static_cast<std::size_t>(box_.size.x());
  ChangedSlice& slice = slices_[static_cast<std::size_t>(z)];
  std::vector<Range> columns(width);
  std::vector<std::uint8_t> fresh(width);
  for (int y = 0; y < box_.size.y(); ++y) {
    std::uint8_t& is_changed = slice.rows[static_cast<std::size_t>(y)];
    if (is_changed == 0) continue;
    is_changed = 0;
    const std::size_t begin =
        width * (static_cast<std::size_t>(y) + static_cast<std::size_t>(box_.size.y()) * static_cast<std::size_t>(z));
    if (!update_row(begin, fresh)) continue;
    for (std::size_t x = 0; x < width; ++x) {
      if (along_x_[begin + x] == fresh[x]) continue;
      along_x_[begin + x] = fresh[x];
      columns[x].add(y);
    }
  }
  for (std::size_t x = 0; x < width; ++x) {
    if (columns[x].last >= 0) update_along_y(z, static_cast<int>(x), columns[x].first, columns[x].last);
  }
}

// Works out a row anew; false if it is as before.
bool DistanceCells::update_row(std::size_t begin, std::vector<std::uint8_t>& fresh) {
  const auto most = static_cast<std::uint8_t>(reach_);
  const auto pass = [&](std::size_t x, std::uint8_t& since) {
    since = members_[begin + x] > 0 ? std::uint8_t{0} : since >= most ? kNoneInRow : static_cast<std::uint8_t>(since + 1);
    return since;
  };
  std::uint8_t since = kNoneInRow;
  for (std::size_t x = 0; x < fresh.size(); ++x) fresh[x] = pass(x, since);
  since = kNoneInRow;
  for (std::size_t x = fresh.size(); x-- > 0;) fresh[x] = std::min(fresh[x], pass(x, since));
  return !std::equal(fresh.begin(), fresh.end(), along_x_.begin() + static_cast<std::ptrdiff_t>(begin));
}

void DistanceCells::update_along_y(int z, int x, int first, int last) {
  const int begin = std::max(0, first - reach_);
  const int end = std::min(box_.size.y(), last + reach_ + 1);
  const auto at = [&](int y) { return box_.index(box_.low + Cell(x, y, z)); };
  std::vector<int> in(static_cast<std::size_t>(end - begin + 2 * reach_), kFarSquare);
  for (int y = std::max(0, begin - reach_); y < std::min(box_.size.y(), end + reach_); ++y) {
    in[static_cast<std::size_t>(y - begin + reach_)] = square_of_row(along_x_[at(y)]);
  }
  std::vector<int> out;
  if (all_far(in)) {
    out.assign(static_cast<std::size_t>(end - begin), kFar);
  } else {
    least_along(in, reach_, out);
  }
  for (int y = begin; y < end; ++y) {
    const auto value = static_cast<std::uint16_t>(out[static_cast<std::size_t>(y - begin)]);
    if (along_y_[at(y)] == value) continue;
    along_y_[at(y)] = value;
    touched_[at(y)] = 1;
  }
}

std::size_t DistanceCells::update_along_z(int y) {
  const auto width = static_cast<std::size_t>(box_.size.x());
  std::vector<Range> columns(width);
  for (int z = 0; z < box_.size.z(); ++z) {
    if (!slices_[static_cast<std::size_t>(z)].any) continue;
    const std::size_t begin = box_.index(box_.low + Cell(0, y, z));
    for (std::size_t x = 0; x < width; ++x) {
      if (touched_[begin + x] == 0) continue;
      touched_[begin + x] = 0;
      columns[x].add(z);
    }
  }
  std::size_t changed = 0;
  std::vector<int> in;
  std::vector<int> out;
  for (std::size_t x = 0; x < width; ++x) {
    if (columns[x].last < 0) continue;
    const int begin = std::max(0, columns[x].first - reach_);
    const int end = std::min(box_.size.z(), columns[x].last + reach_ + 1);
    in.assign(static_cast<std::size_t>(end - begin + 2 * reach_), kFarSquare);
    for (int z = std::max(0, begin - reach_); z < std::min(box_.size.z(), end + reach_); ++z) {
      in[static_cast<std::size_t>(z - begin + reach_)] =
          square_or_far(along_y_[box_.index(box_.low + Cell(static_cast<int>(x), y, z))]);
    }
    least_along(in, reach_, out);
    changed += write_column(static_cast<int>(x), y, out, begin);
  }
  return changed;
}

std::size_t DistanceCells::write_column(int x, int y, const std::vector<int>& fresh, int begin) {
  std::size_t changed = 0;
  for (std::size_t i = 0; i < fresh.size(); ++i) {
    std::uint16_t& value = result_[box_.index(box_.low + Cell(x, y, begin + static_cast<int>(i)))];
    changed += value != fresh[i] ? 1U : 0U;
    value = static_cast<std::uint16_t>(fresh[i]);
  }
  return changed;
}

}  // namespace panoptic
