// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/visible_things.h"

#include <algorithm>
#include <cmath>

namespace panoptic {
namespace {

constexpr std::size_t kNone = SIZE_MAX;

struct Tally {
  VisibleThing thing;
  Vec3d sum = Vec3d::Zero();
};

// Position by instance number.
std::vector<std::size_t> position_table(const std::vector<VisibleThing>& things) {
  std::vector<std::size_t> table(things.empty() ? 1 : std::size_t{things.back().instance} + 1, kNone);
  for (std::size_t i = 0; i < things.size(); ++i) table[things[i].instance] = i;
  return table;
}

void add_run(const Rendering& r, const Camera& camera, int begin, int end, int v, Tally& tally) {
  VisibleThing& thing = tally.thing;
  if (thing.area_px == 0) thing = {r.instance(begin, v), r.class_id(begin, v), 0, begin, v, end - 1, v, 0, Vec3d::Zero()};
  thing.area_px += end - begin;
  thing.x0 = std::min(thing.x0, begin);
  thing.x1 = std::max(thing.x1, end - 1);
  thing.y1 = v;
  const bool edge_row = v == 0 || v == r.instance.height() - 1;
  thing.border_px += edge_row ? end - begin : (begin == 0 ? 1 : 0) + (end == r.instance.width() ? 1 : 0);
  // the run stands for its pixels by its middle: enough for where a thing is
  const int middle = (begin + end) / 2;
  tally.sum += (end - begin) * back_project(camera, middle, v, static_cast<double>(r.depth(middle, v)));
}

}  // namespace

std::vector<VisibleThing> visible_things(const Rendering& r, const Camera& camera) {
  std::vector<Tally> tallies;
  for (int v = 0; v < r.instance.height(); ++v) {
    const std::uint16_t* row = r.instance.row(v);
    for (int begin = 0, end = 0; begin < r.instance.width(); begin = end) {
      for (end = begin + 1; end < r.instance.width() && row[end] == row[begin];) ++end;
      if (row[begin] == 0) continue;
      if (row[begin] >= tallies.size()) tallies.resize(std::size_t{row[begin]} + 1);
      add_run(r, camera, begin, end, v, tallies[row[begin]]);
    }
  }
  std::vector<VisibleThing> things;
  for (Tally& tally : tallies) {
    if (tally.thing.area_px == 0) continue;
    tally.thing.center_m = tally.sum / tally.thing.area_px;
    things.push_back(tally.thing);
  }
  return things;
}

std::vector<std::pair<std::size_t, std::size_t>> touching_pairs(const Rendering& r, const std::vector<VisibleThing>& things) {
  constexpr int kStep_px = 4;
  constexpr int kGap_px = 12;  // two things are next to each other if so few pixels lie between them
  constexpr float kGap_m = 0.4F;
  const std::vector<std::size_t> position = position_table(things);
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  const auto look = [&](int u, int v, int u2, int v2) {
    const std::uint16_t a = r.instance(u, v);
    const std::uint16_t b = r.instance(u2, v2);
    if (a == 0 || b == 0 || a == b || r.class_id(u, v) != r.class_id(u2, v2)) return;
    if (std::abs(r.depth(u, v) - r.depth(u2, v2)) > kGap_m) return;
    pairs.emplace_back(position[std::min(a, b)], position[std::max(a, b)]);
  };
  for (int v = 0; v < r.instance.height(); v += kStep_px) {
    for (int u = 0; u < r.instance.width(); u += kStep_px) {
      if (u + kGap_px < r.instance.width()) look(u, v, u + kGap_px, v);
      if (v + kGap_px < r.instance.height()) look(u, v, u, v + kGap_px);
    }
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

}  // namespace panoptic
