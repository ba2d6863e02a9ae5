// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/movers.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "panoptic/sim/mover_track.h"
#include "panoptic/sim/sensor_noise.h"
#include "panoptic/sim/walk.h"
#include "panoptic/sim/ways.h"

namespace panoptic {
namespace {

constexpr std::uint64_t kPurpose = 0x6d6f7665;
constexpr double kHead_m = 1.95;
constexpr double kFromCamera_m = 0.8;  // nobody wants to be nearer to who films, or to each other
constexpr double kFromOthers_m = 0.7;
constexpr int kTries = 30;            // next activities that are thought of
constexpr double kAfter_s = 4;        // a place must stay free for so long after the activity
constexpr double kSqueeze_m = 0.15;   // legs pass between a sofa and its table
constexpr double kFeet_m = 0.45;      // who sits has the feet so far before the body
constexpr double kNearCamera = 0.65;  // share of ways that lead to the room that is being filmed: else nobody would be seen

// A seat that one comes to on foot.
struct FreeSeat {
  int cell = 0;
  Vec3d position = Vec3d::Zero();
  double heading = 0;
};

class MoverPlan {
 public:
  MoverPlan(const Home& home, const ClearanceMap& clearance, const std::vector<Pose>& path)
      : home_(home), clearance_(clearance), path_(path) {}

  Mover make(const Body& body, const std::vector<TrueSeat>& seats, Random& random) {
    body_m_ = body.kind == BodyKind::kPerson ? 0.27 : (body.kind == BodyKind::kDog ? 0.3 : 0.22);
    Mover mover;
    mover.body = body;
    const std::vector<FreeSeat> free = body.kind == BodyKind::kPerson ? free_seats(seats) : std::vector<FreeSeat>();
    MoverTrack track(start(random));
    while (track.poses.size() < path_.size()) next(mover, free, random, track);
    track.poses.resize(path_.size());
    track.activities.resize(path_.size());
    mover.poses = std::move(track.poses);
    mover.activities = std::move(track.activities);
    others_.push_back(mover.poses);
    return mover;
  }

 private:
  Eigen::Vector2d camera(std::size_t frame) const { return path_[std::min(frame, path_.size() - 1)].translation().head<2>(); }

  // How near the camera or another mover comes, as a share of what is near enough; 1 = never too near.
  double freedom(const std::vector<BodyPose>& poses, std::size_t first_frame, std::size_t from) const {
    double least = 1;
    for (std::size_t i = from; i < poses.size(); ++i) {
      const std::size_t frame = std::min(first_frame + i - from, path_.size() - 1);
      least = std::min(least, (poses[i].at - camera(frame)).norm() / kFromCamera_m);
      for (const auto& other : others_) least = std::min(least, (poses[i].at - other[frame].at).norm() / kFromOthers_m);
    }
    return least;
  }

  std::optional<int> spot(std::uint32_t room, Random& random) const {
    const Eigen::AlignedBox2d& floor = home_.rooms[room].floor;
    for (int i = 0; i < 12; ++i) {
      const double x = random.uniform(floor.min().x(), floor.max().x());
      const double y = random.uniform(floor.min().y(), floor.max().y());
      const int cell = clearance_.cell_at({x, y});
      if (clearance_[cell] > body_m_ + 0.04) return cell;
    }
    return std::nullopt;
  }

  BodyPose start(Random& random) const {
    BodyPose best;
    double most = -1;
    for (int i = 0; i < 4 * kTries; ++i) {
      const auto cell = spot(static_cast<std::uint32_t>(random.index(home_.rooms.size())), random);
      if (!cell) continue;
      BodyPose pose;
      pose.at = clearance_.middle(*cell);
      pose.heading = random.uniform(-std::numbers::pi, std::numbers::pi);
      const double free = freedom(std::vector<BodyPose>(static_cast<std::size_t>(kAfter_s * kFrameRate_hz), pose), 0, 0);
      if (free <= most) continue;
      most = free;
      best = pose;
      if (free >= 1) break;
    }
    return best;
  }

  // Before each seat the nearest place where a person can stand.
  std::vector<FreeSeat> free_seats(const std::vector<TrueSeat>& seats) const {
    std::vector<FreeSeat> free;
    for (const TrueSeat& seat : seats) {
      for (double ahead_m = kFeet_m; ahead_m < kFeet_m + 0.4; ahead_m += 0.05) {
        const Eigen::Vector2d feet = seat.position.head<2>() + ahead_m * seat.facing;
        const int cell = clearance_.cell_at(feet);
        if (clearance_[cell] < kSqueeze_m) continue;
        // Whoever cannot put the feet near sits on the edge.
        const Eigen::Vector2d at = clearance_.middle(cell) - std::min(ahead_m, kFeet_m + 0.08) * seat.facing;
        free.push_back({cell, {at.x(), at.y(), seat.position.z()}, std::atan2(seat.facing.y(), seat.facing.x())});
        break;
      }
    }
    return free;
  }

  std::uint32_t room_of_camera(std::size_t frame) const {
    const Eigen::Vector2d at = camera(frame);
    std::uint32_t nearest = 0;
    for (std::uint32_t room = 1; room < home_.rooms.size(); ++room) {
      if (home_.rooms[room].floor.squaredExteriorDistance(at) < home_.rooms[nearest].floor.squaredExteriorDistance(at))
        nearest = room;
    }
    return nearest;
  }

  std::optional<FreeSeat> choose_seat(const std::vector<FreeSeat>& free, std::size_t frame, Random& random) const {
    std::vector<FreeSeat> near;
    const Eigen::AlignedBox2d& floor = home_.rooms[room_of_camera(frame)].floor;
    for (const FreeSeat& seat : free) {
      if (floor.contains(seat.position.head<2>())) near.push_back(seat);
    }
    if (!near.empty() && random.chance(kNearCamera)) return random.pick(near);
    return free.empty() ? std::nullopt : std::optional(random.pick(free));
  }

  // Squeezes in between a seat and what stands before it, sits, and comes out again.
  bool sit(const FreeSeat& seat, double speed, double seconds, MoverTrack& track) const {
    const WaysFrom ways = ways_from(clearance_, clearance_.cell_at(track.poses.back().at), kSqueeze_m);
    if (!std::isfinite(ways.cost[static_cast<std::size_t>(seat.cell)])) return false;
    std::vector<Eigen::Vector2d> way = smooth_way(clearance_, ways, seat.cell, kSqueeze_m, kStep_m);
    track.walk(way, speed);
    track.turn_to(seat.heading);
    track.sit(seat.position, seconds);
    std::reverse(way.begin(), way.end());
    const auto open = std::find_if(
        way.begin(), way.end(), [&](const Eigen::Vector2d& at) { return clearance_[clearance_.cell_at(at)] > body_m_ + 0.04; });
    if (open == way.end()) return false;
    way.erase(open + 1, way.end());
    track.walk(way, speed);
    return true;
  }

  // One thing to do next; false if it leads nowhere.
  bool think(const Mover& mover, const std::vector<FreeSeat>& free, const WaysFrom& ways, Random& random,
             MoverTrack& track) const {
    const bool is_person = mover.body.kind == BodyKind::kPerson;
    const std::size_t soon = track.poses.size() + static_cast<std::size_t>(kAfter_s * kFrameRate_hz);
    const double speed = is_person ? random.uniform(0.5, 1.3) : random.uniform(0.4, 0.9);
    const auto seat = random.chance(0.35) ? choose_seat(free, soon, random) : std::nullopt;
    const bool is_near = random.chance(kNearCamera);
    const auto room = is_near ? room_of_camera(soon) : static_cast<std::uint32_t>(random.index(home_.rooms.size()));
    const double seconds = random.uniform(1, 7);
    if (seat) return sit(*seat, speed, 2 * seconds, track);
    const auto cell = spot(room, random);
    if (!cell || !std::isfinite(ways.cost[static_cast<std::size_t>(*cell)])) return false;
    track.walk(smooth_way(clearance_, ways, *cell, body_m_, kStep_m), speed);
    if (!is_person && random.chance(0.4)) {
      track.lie(seconds);
    } else {
      track.stand(seconds);
    }
    return true;
  }

  // Takes the first of several ideas that keeps clear of everybody, else the one that keeps clearest.
  void next(const Mover& mover, const std::vector<FreeSeat>& free, Random& random, MoverTrack& track) const {
    const std::size_t begin = track.poses.size();
    const WaysFrom ways = ways_from(clearance_, clearance_.cell_at(track.poses.back().at), body_m_);
    std::optional<MoverTrack> best;
    double most = -1;
    for (int i = 0; i < kTries && most < 1; ++i) {
      MoverTrack idea(track.poses.back());
      if (i == 0 && begin > 1) {
        idea.stand(1);  // to stay where one is
      } else if (!think(mover, free, ways, random, idea)) {
        continue;
      }
      std::vector<BodyPose> watched = idea.poses;
      watched.resize(watched.size() + static_cast<std::size_t>(kAfter_s * kFrameRate_hz), watched.back());
      // To stay is the last thing that comes to mind, since it shows nobody walking.
      const double free_share = std::min(freedom(watched, begin, 1), i == 0 ? 0.999 : 1.0);
      if (free_share <= most) continue;
      most = free_share;
      best = std::move(idea);
    }
    if (!best) {
      track.stand(1);
      return;
    }
    track.poses.insert(track.poses.end(), best->poses.begin() + 1, best->poses.end());
    track.activities.insert(track.activities.end(), best->activities.begin() + 1, best->activities.end());
  }

  const Home& home_;
  const ClearanceMap& clearance_;
  const std::vector<Pose>& path_;
  double body_m_ = 0.27;
  std::vector<std::vector<BodyPose>> others_;
};

}  // namespace

std::vector<Mover> plan_movers(const Home& home, const std::vector<TrueSeat>& seats, const std::vector<Pose>& path,
                               const MoverOptions& options) {
  const ClearanceMap clearance = walking_clearance(home, kHead_m);
  MoverPlan plan(home, clearance, path);
  std::vector<Mover> movers;
  const auto add = [&](BodyKind kind, int count) {
    for (int i = 0; i < count; ++i) {
      Random random(options.seed, kPurpose, 1 + movers.size());
      const Body body = random_body(kind, random);
      movers.push_back(plan.make(body, seats, random));
      movers.back().instance = static_cast<std::uint16_t>(options.first_instance + movers.size() - 1);
    }
  };
  add(BodyKind::kPerson, options.people);
  add(BodyKind::kCat, options.cats);
  add(BodyKind::kDog, options.dogs);
  return movers;
}

}  // namespace panoptic
