// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/jumps.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <optional>
#include <span>

#include "panoptic/base/json.h"
#include "panoptic/error.h"
#include "panoptic/sim/random.h"

namespace panoptic {
namespace {

constexpr std::uint64_t kPurpose = 0x6a756d70;
constexpr double kDegree = std::numbers::pi / 180;
// A camera stands near another, and looks the same way.
constexpr double kNear_m = 0.4;
constexpr double kNear_rad = 20 * kDegree;
// A camera is elsewhere if it stands this far away, or looks another way.
constexpr double kElsewhere_m = 1;
constexpr double kElsewhere_rad = 50 * kDegree;
// A place was not seen if no camera looked the same way from so near.
constexpr double kUnseen_m = 0.8;
constexpr double kUnseen_rad = 60 * kDegree;
// The way keeps 25 cm from everything.
constexpr double kBeside_m = 0.12;
constexpr double kHigher_m = 0.06;
constexpr double kTurned_rad = 8 * kDegree;
constexpr double kRolled_rad = 3 * kDegree;

// A longer path is compared by every second pose, every third ...: they are close to one another.
constexpr std::size_t kMostCompared = 2000;
constexpr std::size_t kMostJumps = 100;

bool is_within(const Pose& a, const Pose& b, double distance_m, double angle_rad) {
  if ((a.translation() - b.translation()).norm() >= distance_m) return false;
  return Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle() < angle_rad;
}

bool is_any_within(std::span<const Pose> poses, const Pose& pose, double distance_m, double angle_rad) {
  const std::size_t step = 1 + poses.size() / kMostCompared;
  for (std::size_t i = 0; i < poses.size(); i += step) {
    if (is_within(poses[i], pose, distance_m, angle_rad)) return true;
  }
  return false;
}

// The first frame of each stretch but the first, and the end.
std::vector<std::size_t> ends_of_stretches(std::size_t frames, std::size_t jumps, Random& random) {
  std::vector<std::size_t> ends;
  const double first = static_cast<double>(frames) / 3;
  const double step = (static_cast<double>(frames) - first) / static_cast<double>(jumps);
  constexpr double kLatest = 0.3;
  for (std::size_t i = 0; i < jumps; ++i) {
    ends.push_back(static_cast<std::size_t>(first + step * (static_cast<double>(i) + random.uniform(0, kLatest))));
  }
  ends.push_back(frames);
  return ends;
}

Pose put_beside(const Pose& pose, const Pose& offset) {
  Pose beside = pose;
  beside.translation() += offset.translation();
  beside.linear() = offset.linear() * pose.linear();
  return beside;
}

// The offset in the world by which the camera is put down beside the path.
Pose offset_by(Random& random) {
  Pose offset = Pose::Identity();
  const double way = random.uniform(0, 2 * std::numbers::pi);
  const double far_m = random.uniform(0.25, 1) * kBeside_m;
  offset.translation() = Vec3d(far_m * std::cos(way), far_m * std::sin(way), random.uniform(-kHigher_m, kHigher_m));
  const Vec3d tilt(random.uniform(-kRolled_rad, kRolled_rad), random.uniform(-kRolled_rad, kRolled_rad), 0);
  offset.linear() = (Eigen::AngleAxisd(random.uniform(-kTurned_rad, kTurned_rad), Vec3d::UnitZ()) *
                     Eigen::AngleAxisd(tilt.norm(), tilt.normalized()))
                        .toRotationMatrix();
  return offset;
}

// Places of the path to be put down at, by how well they are what is wanted.
struct Choices {
  std::vector<std::size_t> seen;
  std::vector<std::size_t> unseen;
  std::vector<std::size_t> elsewhere;  // neither the one nor the other for certain
};

Choices choices_of(const std::vector<Pose>& path, std::size_t places, const Pose& offset, std::span<const Pose> before) {
  Choices choices;
  const std::size_t step = 1 + places / kMostCompared;
  for (std::size_t i = 0; i < places; i += step) {
    const Pose there = put_beside(path[i], offset);
    if (is_within(there, before.back(), kElsewhere_m, kElsewhere_rad)) continue;
    choices.elsewhere.push_back(i);
    if (is_any_within(before, there, kNear_m, kNear_rad)) choices.seen.push_back(i);
    if (!is_any_within(before, there, kUnseen_m, kUnseen_rad)) choices.unseen.push_back(i);
  }
  return choices;
}

std::size_t chosen(const Choices& choices, bool wants_seen, std::size_t places, Random& random) {
  const std::vector<std::size_t>& wanted = wants_seen ? choices.seen : choices.unseen;
  if (!wanted.empty()) return random.pick(wanted);
  const std::vector<std::size_t>& others = wants_seen ? choices.unseen : choices.seen;
  if (!others.empty()) return random.pick(others);
  return choices.elsewhere.empty() ? random.index(places) : random.pick(choices.elsewhere);
}

Json rows_of(const Pose& pose) {
  Json rows = Json::array();
  for (int row = 0; row < 4; ++row) {
    rows.push_back({pose(row, 0), pose(row, 1), pose(row, 2), pose(row, 3)});
  }
  return rows;
}

}  // namespace

JumpingPath with_jumps(const std::vector<Pose>& path, int jumps, std::uint64_t seed) {
  const std::size_t most = std::min(kMostJumps, path.size() / kFramesForAJump);
  if (jumps < 0 || static_cast<std::size_t>(jumps) > most) {
    throw Error(fmt::format("jumps = {} do not fit {} frames: one takes {} frames; ask for 0 to {}, or for more frames", jumps,
                            path.size(), kFramesForAJump, most));
  }
  JumpingPath result{path, {}};
  if (jumps == 0) return result;
  Random random(seed, kPurpose);
  const std::vector<std::size_t> ends = ends_of_stretches(path.size(), static_cast<std::size_t>(jumps), random);
  constexpr std::size_t kUnseenEvery = 3;
  for (std::size_t j = 0; j + 1 < ends.size(); ++j) {
    const std::size_t begin = ends[j];
    const std::size_t places = path.size() - (ends[j + 1] - begin) + 1;  // from which the path is long enough
    const Pose offset = offset_by(random);
    const std::span<const Pose> before(result.poses.data(), begin);
    const bool wants_seen = (j + 1) % kUnseenEvery != 0;
    const std::size_t place = chosen(choices_of(path, places, offset, before), wants_seen, places, random);
    const bool is_seen = is_any_within(before, put_beside(path[place], offset), kNear_m, kNear_rad);
    for (std::size_t i = begin; i < ends[j + 1]; ++i) result.poses[i] = put_beside(path[place + i - begin], offset);
    result.jumps.push_back({begin, result.poses[begin - 1], result.poses[begin], is_seen});
  }
  return result;
}

void write_jumps(const std::filesystem::path& path, const JumpingPath& truth, double rate_hz) {
  Json json = {{"format", "panoptic jumps"},
               {"version", 1},
               {"rate_hz", rate_hz},
               {"frames", truth.poses.size()},
               {"jumps", Json::array()}};
  for (const Jump& jump : truth.jumps) {
    json["jumps"].push_back({{"frame", jump.frame},
                             {"time_s", static_cast<double>(jump.frame) / rate_hz},
                             {"seen_before", jump.is_seen},
                             {"from", rows_of(jump.from)},
                             {"to", rows_of(jump.to)}});
  }
  write_json_file(path, json);
}

}  // namespace panoptic
