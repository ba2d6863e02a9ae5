// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/camera_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "panoptic/error.h"
#include "panoptic/sim/random.h"
#include "panoptic/sim/walk.h"

namespace panoptic {
namespace {

constexpr std::uint64_t kPurpose = 0xca3e2a;
constexpr int kMostFrames = 1'000'000;
constexpr double kRate_hz = 30;
constexpr double kBeat_s = 0.8;  // between two decisions where to look
constexpr double kRadian = std::numbers::pi / 180;
constexpr double kTurn_rad = 38 * kRadian;  // per beat, at most
constexpr double kHead_m = 1.75;            // what is lower can be run into
constexpr int kMostBeatsAtStop = 8;
constexpr double kWorthStaying = 1.6;  // weight of new sights for which a person stays another beat
constexpr double kHalfWidth = 0.5;     // of the view that counts as seen, as tangents: a little less than the camera's
constexpr double kHalfHeight = 0.36;

// The camera's choice at one beat.
struct Beat {
  double along_m = 0;  // of the walk
  double yaw = 0;      // continuous, may exceed a turn
  double pitch = 0;    // negative looks down
};

Vec3d direction(double yaw, double pitch) {
  return {std::cos(yaw) * std::cos(pitch), std::sin(yaw) * std::cos(pitch), std::sin(pitch)};
}

// Follows the walk and turns to what has not been seen yet.
class Gaze {
 public:
  // `laps`: the walk goes round so often, and every time all is worth looking at again.
  Gaze(const Home& home, const Walk& walk, std::vector<Sight> sights, int laps)
      : home_(home), walk_(walk), sights_(std::move(sights)), times_seen_(sights_.size(), 0), laps_(laps) {}

  std::vector<Beat> follow(Random& random) {
    std::vector<Beat> beats;
    Beat beat;
    beat.yaw = heading(0);
    beat.pitch = -20 * kRadian;
    const double length_m = static_cast<double>(walk_.points.size() - 1) * kStep_m;
    std::size_t stop = 0;
    int stayed = 0;
    int lap = 1;
    double gain = turn(beat);
    beats.push_back(beat);
    while (beat.along_m < length_m) {
      const double stop_m = stop < walk_.look_around.size() ? static_cast<double>(walk_.look_around[stop]) * kStep_m : length_m;
      if (stop < walk_.look_around.size() && beat.along_m >= stop_m) {
        if (gain > kWorthStaying && stayed < kMostBeatsAtStop) {
          ++stayed;
        } else {
          ++stop;
          stayed = 0;
          continue;
        }
      } else {
        beat.along_m = std::min({beat.along_m + kBeat_s * random.uniform(0.58, 0.72), stop_m, length_m});
      }
      if (lap < laps_ && beat.along_m >= lap * length_m / laps_) {
        ++lap;
        times_seen_.assign(sights_.size(), 0);
      }
      gain = turn(beat);
      beats.push_back(beat);
    }
    return beats;
  }

 private:
  Eigen::Vector2d point(double along_m) const {
    const auto index = static_cast<std::size_t>(along_m / kStep_m);
    return walk_.points[std::min(index, walk_.points.size() - 1)];
  }

  // The direction of the walk, half a metre ahead.
  double heading(double along_m) const {
    const Eigen::Vector2d ahead = point(along_m + 0.5) - point(along_m);
    return ahead.norm() < 1e-6 ? 0 : std::atan2(ahead.y(), ahead.x());
  }

  bool is_near_room(std::uint32_t room, const Eigen::Vector2d& eye) const {
    return home_.rooms[room].floor.squaredExteriorDistance(eye) < 0.2 * 0.2;
  }

  // The sights within reach of the eye, in any direction.
  std::vector<std::size_t> around(const Vec3d& eye) const {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < sights_.size(); ++i) {
      if (is_near_room(sights_[i].room, eye.head<2>()) && is_in_reach(sights_[i], eye)) found.push_back(i);
    }
    return found;
  }

  static bool is_in_view(const Vec3d& offset, double yaw, double pitch) {
    const Vec3d forward = direction(yaw, pitch);
    const Vec3d right(std::sin(yaw), -std::cos(yaw), 0);
    const Vec3d down = forward.cross(right);
    const double depth_m = offset.dot(forward);
    return depth_m > 0 && std::abs(offset.dot(right)) < kHalfWidth * depth_m &&
           std::abs(offset.dot(down)) < kHalfHeight * depth_m;
  }

  double value(std::size_t sight) const {
    const double again = 1.0 + times_seen_[sight];
    return sights_[sight].weight / (again * again);
  }

  // Turns the beat towards the most rewarding direction as far as one beat allows, and notes what is seen then. Returns the
  // weight of what is new in that best direction.
  double turn(Beat& beat) {
    const Eigen::Vector2d at = point(beat.along_m);
    const Vec3d eye(at.x(), at.y(), 1.45);
    const std::vector<std::size_t> near = around(eye);
    const double ahead = heading(beat.along_m);
    double best_score = -1;
    double best_turn = 0;
    double best_pitch = beat.pitch;
    double best_new = 0;
    for (int step = -18; step < 18; ++step) {
      const double turned = step * 10 * kRadian;
      for (const double pitch : {-10 * kRadian, -20 * kRadian, -31 * kRadian}) {
        double reward = 0.5 + 0.35 * std::cos(beat.yaw + turned - ahead);
        double fresh = 0;
        for (const std::size_t i : near) {
          if (!is_in_view(sights_[i].point - eye, beat.yaw + turned, pitch)) continue;
          reward += value(i);
          if (times_seen_[i] == 0) fresh += sights_[i].weight;
        }
        const double score = reward * std::exp(-std::abs(turned) / (80 * kRadian));
        if (score <= best_score) continue;
        best_score = score;
        best_turn = turned;
        best_pitch = pitch;
        best_new = fresh;
      }
    }
    beat.yaw += std::clamp(best_turn, -kTurn_rad, kTurn_rad);
    beat.pitch += std::clamp(best_pitch - beat.pitch, -14 * kRadian, 14 * kRadian);
    for (const std::size_t i : near) {
      if (is_in_view(sights_[i].point - eye, beat.yaw, beat.pitch)) times_seen_[i] = std::min(times_seen_[i] + 1, 5);
    }
    return best_new;
  }

  const Home& home_;
  const Walk& walk_;
  std::vector<Sight> sights_;
  std::vector<int> times_seen_;
  int laps_;
};

// A smooth curve through values one apart that never overshoots (monotone cubic of Fritsch and Carlson).
double interpolate(const std::vector<double>& values, double at) {
  const int last = static_cast<int>(values.size()) - 1;
  const int i = std::clamp(static_cast<int>(at), 0, std::max(0, last - 1));
  const auto value = [&](int k) { return values[static_cast<std::size_t>(std::clamp(k, 0, last))]; };
  const auto slope = [&](int k) {
    const double before = value(k) - value(k - 1);
    const double after = value(k + 1) - value(k);
    return before * after <= 0 ? 0.0 : 2 * before * after / (before + after);
  };
  const double t = at - i;
  const double a = value(i);
  const double b = value(i + 1);
  return a + t * t * (3 - 2 * t) * (b - a) + t * (1 - t) * ((1 - t) * slope(i) - t * slope(i + 1));
}

// Slow or fast wandering around 0, at most 1: three waves with phases of their own.
class Sway {
 public:
  Sway(Random& random, double slowest_hz) {
    for (std::size_t i = 0; i < waves_.size(); ++i) {
      waves_[i] = {slowest_hz * (1 + 0.77 * static_cast<double>(i)) * random.uniform(0.9, 1.1),
                   random.uniform(0, 2 * std::numbers::pi)};
    }
  }
  double at(double time_s) const {
    double sum = 0;
    for (const auto& [frequency_hz, phase] : waves_) sum += std::sin(2 * std::numbers::pi * frequency_hz * time_s + phase);
    return sum / static_cast<double>(waves_.size());
  }

 private:
  std::array<std::pair<double, double>, 3> waves_;
};

// The beats as a motion in continuous time, with what a hand adds to it.
class Motion {
 public:
  Motion(const Walk& walk, const std::vector<Beat>& beats, Random& random)
      : walk_(walk),
        height_(random, 0.045),
        roll_(random, 0.11),
        sideways_(random, 0.31),
        yaw_shake_(random, 0.7),
        pitch_shake_(random, 0.8),
        middle_height_m_(random.uniform(1.40, 1.50)) {
    for (const Beat& beat : beats) {
      along_m_.push_back(beat.along_m);
      yaw_.push_back(beat.yaw);
      pitch_.push_back(beat.pitch);
    }
  }

  double length_s() const { return static_cast<double>(along_m_.size() - 1) * kBeat_s; }

  Pose at(double time_s) const {
    const double along_m = interpolate(along_m_, time_s / kBeat_s);
    const double yaw = interpolate(yaw_, time_s / kBeat_s) + 0.8 * kRadian * yaw_shake_.at(time_s);
    const double pitch = interpolate(pitch_, time_s / kBeat_s) + 0.7 * kRadian * pitch_shake_.at(time_s);
    const Vec3d forward = direction(yaw, pitch);
    const Vec3d level(std::sin(yaw), -std::cos(yaw), 0);
    const Vec3d right = Eigen::AngleAxisd(2.0 * kRadian * roll_.at(time_s), forward) * level;
    const Eigen::Vector2d foot = point(along_m) + level.head<2>() * (0.015 * sideways_.at(time_s));
    // A step is 0.6 m long; the hand rises and sinks with it.
    const double bob_m = 0.012 * std::sin(2 * std::numbers::pi * along_m / 0.6);
    Pose world_from_camera = Pose::Identity();
    world_from_camera.linear().col(0) = right;
    world_from_camera.linear().col(1) = forward.cross(right);
    world_from_camera.linear().col(2) = forward;
    world_from_camera.translation() = Vec3d(foot.x(), foot.y(), middle_height_m_ + 0.17 * height_.at(time_s) + bob_m);
    return world_from_camera;
  }

 private:
  Eigen::Vector2d point(double along_m) const {
    const double step = along_m / kStep_m;
    const auto index = std::min(static_cast<std::size_t>(step), walk_.points.size() - 1);
    const std::size_t next = std::min(index + 1, walk_.points.size() - 1);
    return walk_.points[index] + (walk_.points[next] - walk_.points[index]) * (step - static_cast<double>(index));
  }

  const Walk& walk_;
  std::vector<double> along_m_;
  std::vector<double> yaw_;
  std::vector<double> pitch_;
  Sway height_;
  Sway roll_;
  Sway sideways_;
  Sway yaw_shake_;
  Sway pitch_shake_;
  double middle_height_m_;
};

// The walk so many times, one after the other: it ends where it begins.
Walk repeated(const Walk& once, int laps) {
  Walk walk = once;
  for (int lap = 1; lap < laps; ++lap) {
    const std::size_t offset = walk.points.size() - 1;
    walk.points.insert(walk.points.end(), once.points.begin() + 1, once.points.end());
    for (const std::size_t stop : once.look_around) walk.look_around.push_back(offset + stop);
  }
  return walk;
}

}  // namespace

std::vector<Pose> make_camera_path(const Home& home, const PathOptions& options) {
  if (options.frames < 0 || options.frames > kMostFrames) {
    throw Error(fmt::format("frames = {}: a camera path has 1 to {} frames, or 0 for as many as the way takes", options.frames,
                            kMostFrames));
  }
  if (home.rooms.empty()) throw Error("a camera path needs a home with at least one room");
  const ClearanceMap clearance = walking_clearance(home, kHead_m);
  const std::vector<Sight> all = sights(home, clearance);
  const Walk walk = repeated(plan_walk(home, clearance, all), options.laps);
  Random random(options.seed, kPurpose);
  const std::vector<Beat> beats = Gaze(home, walk, all, options.laps).follow(random);
  const Motion motion(walk, beats, random);
  const int frames = options.frames > 0 ? options.frames : static_cast<int>(motion.length_s() * kRate_hz) + 1;
  std::vector<Pose> path;
  for (int i = 0; i < frames; ++i) path.push_back(motion.at(frames == 1 ? 0 : motion.length_s() * i / (frames - 1)));
  return path;
}

}  // namespace panoptic
