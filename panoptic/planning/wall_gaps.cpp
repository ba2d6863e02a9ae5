// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/wall_gaps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace panoptic {
namespace {

constexpr double kNarrowest_m = 0.5;  // shoulders
constexpr double kWidest_m = 2.5;     // a double door; what is wider is part of the room
constexpr double kStep_m = 0.025;
constexpr double kJamb_m = 0.15;  // between where one can walk and the wall beside it: rounded edges, reveals, frames

// One can walk from before the face to behind it.
bool passes(const WallPlane& plane, double along_m, const OpenFloor& floor) {
  constexpr std::array kBefore_m = {0.08, 0.04, -0.05, -0.1};
  return std::all_of(kBefore_m.begin(), kBefore_m.end(), [&](double m) { return floor.is_open(plane.at(along_m, m)); });
}

// The stretches of an interval where one can walk through, as far as they are wide enough. Interruptions of one cell are noise.
std::vector<Stretch> passages(const WallPlane& plane, const Stretch& within, const OpenFloor& floor) {
  std::vector<Stretch> found;
  for (double along_m = within.low_m + kStep_m / 2; along_m < within.high_m; along_m += kStep_m) {
    if (!passes(plane, along_m, floor)) continue;
    const Stretch step{along_m - kStep_m / 2, along_m + kStep_m / 2};
    if (!found.empty() && step.low_m - found.back().high_m < 1.5 * floor.grid.cell_m) {
      found.back().high_m = step.high_m;
    } else {
      found.push_back(step);
    }
  }
  std::erase_if(found, [](const Stretch& s) { return s.length_m() < kNarrowest_m - 2 * kStep_m || s.length_m() > kWidest_m; });
  return found;
}

struct Lintel {
  double share = 0;     // of the gap's width that has wall above it
  double bottom_m = 0;  // height above the floor
};

Lintel lintel_above(const WallPlane& plane, const Stretch& gap) {
  constexpr double kBin_m = 0.1;
  const auto bins = static_cast<std::size_t>(std::max(1.0, std::round(gap.length_m() / kBin_m)));
  std::vector<char> covered(bins, 0);
  std::vector<double> heights;
  for (const LabelledPoint& p : plane.points) {
    const double along = (plane.along_m(p.at.head<2>()) - gap.low_m) / gap.length_m();
    if (p.at.z() < kWallHigh_m || along < 0 || along >= 1) continue;
    covered[static_cast<std::size_t>(along * static_cast<double>(bins))] = 1;
    heights.push_back(p.at.z());
  }
  if (heights.empty()) return {};
  const auto low = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 50);
  std::nth_element(heights.begin(), low, heights.end());
  return {static_cast<double>(std::count(covered.begin(), covered.end(), 1)) / static_cast<double>(bins), *low};
}

// The side walls run on before and behind the face at both ends: a corridor that the plane crosses, no doorway.
bool is_crossing(const WallPlane& plane, const Stretch& gap, const OpenFloor& floor) {
  constexpr double kAway_m = 0.45;
  constexpr double kNear_m = 0.15;
  for (const double along_m : {gap.low_m, gap.high_m}) {
    for (const double before_m : {kAway_m, -kAway_m}) {
      if (!floor.has_wall_near(plane.at(along_m, before_m), kNear_m)) return false;
    }
  }
  return true;
}

// The face of the wall's thickness bounds a passage there, and no side wall does: it would run on before the face or behind it.
bool has_reveal(const WallPlane& plane, double end_m, const OpenFloor& floor) {
  constexpr double kInside_m = 0.06;
  constexpr double kAway_m = 0.45;
  constexpr double kNear_m = 0.15;
  constexpr double kTouching_m = 0.1;
  if (!floor.has_wall_near(plane.at(end_m, -kInside_m), kTouching_m)) return false;
  return !floor.has_wall_near(plane.at(end_m, kAway_m), kNear_m) && !floor.has_wall_near(plane.at(end_m, -kAway_m), kNear_m);
}

// One can go on through the middle of the passage behind the thickest wall. A face that stands before a wall, as a curtain's
// does, has the wall behind it.
bool leads_through(const WallPlane& plane, const Stretch& passage, const OpenFloor& floor) {
  constexpr double kThickest_m = 0.5;
  for (double behind_m = 0; behind_m <= kThickest_m; behind_m += kStep_m) {
    if (!floor.is_open(plane.at((passage.low_m + passage.high_m) / 2, -behind_m))) return false;
  }
  return true;
}

// Right before the face is open floor all along, and no wall was seen beyond it: there is none.
bool is_bare(const WallPlane& plane, const Stretch& stretch, const OpenFloor& floor) {
  constexpr double kBefore_m = 0.08;
  for (double along_m = stretch.low_m + kStep_m / 2; along_m < stretch.high_m; along_m += kStep_m) {
    if (!floor.is_open(plane.at(along_m, kBefore_m))) return false;
  }
  return true;
}

// The end of the solid stretch beside an end of a passage; nothing if there is none within the jamb, or farther with nothing
// before.
std::optional<double> solid_beside(const WallPlane& plane, const Stretch& passage, bool at_low_end, const OpenFloor& floor) {
  for (const Stretch& solid : plane.solid) {
    const Stretch between = at_low_end ? Stretch{solid.high_m, passage.low_m} : Stretch{passage.high_m, solid.low_m};
    const bool is_beside = std::abs(between.length_m()) <= kJamb_m;
    const bool is_near = between.length_m() > 0 && between.length_m() <= kNarrowest_m && is_bare(plane, between, floor);
    if (is_beside || is_near) return at_low_end ? solid.high_m : solid.low_m;
  }
  return std::nullopt;
}

std::optional<WallGap> gap_at(const WallPlane& plane, const Stretch& passage, const OpenFloor& floor) {
  const auto low_m = solid_beside(plane, passage, true, floor);
  const auto high_m = solid_beside(plane, passage, false, floor);
  const Stretch width{low_m.value_or(passage.low_m), high_m.value_or(passage.high_m)};
  const Lintel lintel = lintel_above(plane, width);
  const bool has_lintel = lintel.share > 0.6;
  if (!low_m && !high_m && !has_lintel) return std::nullopt;
  // Furniture may hide the wall beside an end. Then the wall around the corner tells, with a lintel or as a reveal.
  const auto is_end = [&](double end_m) {
    return has_lintel ? floor.has_wall_near(plane.at(end_m), 2 * kJamb_m) : has_reveal(plane, end_m, floor);
  };
  if (!low_m && !is_end(passage.low_m)) return std::nullopt;
  if (!high_m && !is_end(passage.high_m)) return std::nullopt;
  if (!(low_m && high_m) && !has_lintel && !leads_through(plane, passage, floor)) return std::nullopt;
  if (!has_lintel && is_crossing(plane, width, floor)) return std::nullopt;
  if (width.length_m() < kNarrowest_m) return std::nullopt;
  return WallGap{width, has_lintel ? lintel.bottom_m : 0, has_lintel};
}

}  // namespace

std::vector<WallGap> find_wall_gaps(const WallPlane& plane, const OpenFloor& floor) {
  if (plane.solid.empty()) return {};
  std::vector<Stretch> between;
  between.push_back({plane.solid.front().low_m - kWidest_m - kJamb_m, plane.solid.front().low_m});
  for (std::size_t i = 0; i + 1 < plane.solid.size(); ++i) between.push_back({plane.solid[i].high_m, plane.solid[i + 1].low_m});
  between.push_back({plane.solid.back().high_m, plane.solid.back().high_m + kWidest_m + kJamb_m});
  std::vector<WallGap> gaps;
  for (const Stretch& interval : between) {
    for (const Stretch& passage : passages(plane, interval, floor)) {
      if (const auto gap = gap_at(plane, passage, floor)) gaps.push_back(*gap);
    }
  }
  return gaps;
}

}  // namespace panoptic
