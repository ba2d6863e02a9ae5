// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/planning/planned_home.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <utility>

namespace panoptic::test {
namespace {

const Camera kSmall{320, 240, 288.9, 288.9, 159.5, 119.5};

// The truth: a segment per thing and per class of stuff.
Segmentation segments_of(const Rendering& r, const LabelSet& labels) {
  Segmentation s{Image<std::uint16_t>(kSmall.width, kSmall.height), {}};
  std::map<std::pair<ClassId, int>, std::uint16_t> segments;
  for (std::size_t i = 0; i < s.segment_at.size(); ++i) {
    if (r.class_id[i] == ClassId::kUnknown) continue;
    const int instance = labels.is_thing(r.class_id[i]) ? r.instance[i] : 0;
    const auto next = static_cast<std::uint16_t>(s.segments.size() + 1);
    const auto [at, is_new] = segments.try_emplace({r.class_id[i], instance}, next);
    if (is_new) s.segments.push_back({r.class_id[i], 1.0F, {}});
    s.segment_at[i] = at->second;
  }
  return s;
}

Polygon from_above(const std::vector<Vec3d>& polygon) {
  Polygon flat;
  for (const Vec3d& corner : polygon) flat.push_back(corner.head<2>());
  return flat;
}

// Pairs of found and wanted with the lowest cost first; none of a cost above `most`.
std::vector<std::pair<std::size_t, std::size_t>> pairs(std::size_t found, std::size_t wanted, double most,
                                                       const std::function<double(std::size_t, std::size_t)>& cost) {
  struct Candidate {
    double cost;
    std::size_t found;
    std::size_t wanted;
  };
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < found; ++i) {
    for (std::size_t j = 0; j < wanted; ++j) {
      if (const double c = cost(i, j); c <= most) candidates.push_back({c, i, j});
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) { return a.cost < b.cost; });
  std::vector<char> found_taken(found, 0);
  std::vector<char> wanted_taken(wanted, 0);
  std::vector<std::pair<std::size_t, std::size_t>> result;
  for (const Candidate& c : candidates) {
    if (found_taken[c.found] != 0 || wanted_taken[c.wanted] != 0) continue;
    found_taken[c.found] = wanted_taken[c.wanted] = 1;
    result.emplace_back(c.found, c.wanted);
  }
  return result;
}

Matches matched(std::size_t found, std::size_t wanted, double most, const std::function<double(std::size_t, std::size_t)>& cost,
                const std::function<double(std::size_t, std::size_t)>& error) {
  Matches matches{static_cast<int>(found), static_cast<int>(wanted), 0, {}};
  for (const auto& [i, j] : pairs(found, wanted, most, cost)) {
    ++matches.matched;
    matches.errors.push_back(error(i, j));
  }
  return matches;
}

double degrees_between(const Vec2d& a, const Vec2d& b) {
  return std::acos(std::clamp(a.normalized().dot(b.normalized()), -1.0, 1.0)) * 180 / std::numbers::pi;
}

}  // namespace

std::unique_ptr<Mapper> map_home(const Simulation& simulation, const Pose& turned_from_world) {
  const LabelSet labels = load_label_set("scannet20");
  Options options;
  options.depth.max_m = 6;
  auto mapper = std::make_unique<Mapper>(options, labels);
  for (std::size_t i = 0; i < simulation.size(); ++i) {
    const Pose pose = simulation.true_path()[i];
    Rendering r = simulation.renderer().render(kSmall, pose);
    Segmentation segmentation = segments_of(r, labels);
    Frame frame;
    frame.index = static_cast<std::int64_t>(i);
    frame.time_s = static_cast<double>(i) / 30;
    frame.depth_camera = frame.color_camera = kSmall;
    frame.world_from_camera = turned_from_world * pose;
    frame.depth = std::move(r.depth);
    frame.color = std::move(r.color);
    const Outcome outcome = mapper->add(frame, segmentation);
    EXPECT_TRUE(outcome.used) << outcome.reason;
  }
  mapper->finish();
  return mapper;
}

HomePlan in_world(HomePlan plan, const Pose& turned_from_world) {
  const Pose world_from_grid = turned_from_world.inverse() * plan.grid_from_world.inverse();
  const auto move = [&](Vec3d& p) { p = world_from_grid * p; };
  const auto turn = [&](Vec3d& v) { v = world_from_grid.linear() * v; };
  const auto move_flat = [&](Vec2d& p) { p = (world_from_grid * Vec3d(p.x(), p.y(), 0)).head<2>(); };
  for (Seat& seat : plan.seats) move(seat.position), turn(seat.facing), turn(seat.normal);
  for (TableTop& top : plan.table_tops) std::for_each(top.polygon.begin(), top.polygon.end(), move);
  for (Opening& door : plan.doors) move(door.center), turn(door.along);
  for (MappedRoom& room : plan.rooms) std::for_each(room.polygon.begin(), room.polygon.end(), move_flat);
  return plan;
}

PlanScores score(const HomePlan& plan, const PlanTruth& truth) {
  PlanScores scores;
  scores.seats = matched(
      plan.seats.size(), truth.seats.size(), 0.25,
      [&](auto i, auto j) { return (plan.seats[i].position - truth.seats[j].position).template head<2>().norm(); },
      [&](auto i, auto j) { return degrees_between(plan.seats[i].facing.template head<2>(), truth.seats[j].facing); });
  const auto table_iou = [&](auto i, auto j) {
    return intersection_over_union(from_above(plan.table_tops[i].polygon), truth.table_tops[j].polygon);
  };
  scores.tables = matched(
      plan.table_tops.size(), truth.table_tops.size(), 0.5, [&](auto i, auto j) { return 1 - table_iou(i, j); }, table_iou);
  scores.doors = matched(
      plan.doors.size(), truth.doors.size(), 0.3,
      [&](auto i, auto j) { return (plan.doors[i].center.template head<2>() - truth.doors[j].center).norm(); },
      [&](auto i, auto j) { return std::abs(plan.doors[i].width_m - truth.doors[j].width_m); });
  const auto room_iou = [&](auto i, auto j) { return intersection_over_union(plan.rooms[i].polygon, truth.rooms[j].polygon); };
  scores.rooms = matched(
      plan.rooms.size(), truth.rooms.size(), 0.25, [&](auto i, auto j) { return 1 - room_iou(i, j); }, room_iou);
  for (const auto& [i, j] :
       pairs(plan.rooms.size(), truth.rooms.size(), 0.25, [&](auto i, auto j) { return 1 - room_iou(i, j); })) {
    if (plan.rooms[i].class_name == name_of(truth.rooms[j].kind)) ++scores.room_classes_right;
  }
  return scores;
}

std::string PlanScores::text() const {
  const auto line = [](const char* name, const Matches& m) {
    std::string errors;
    for (const double e : m.errors) errors += fmt::format(" {:.2f}", e);
    return fmt::format("{}: F1 {:.3f}, {} found, {} true, {} matched:{}\n", name, m.f1(), m.found, m.wanted, m.matched, errors);
  };
  return line("seats", seats) + line("table tops", tables) + line("doors", doors) + line("rooms", rooms) +
         fmt::format("room classes right: {}\n", room_classes_right);
}

}  // namespace panoptic::test
