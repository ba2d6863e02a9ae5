// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/insects.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "panoptic/planning/agent_rules.h"
#include "panoptic/planning/mesh_places.h"

namespace panoptic {
namespace {

namespace rules = agent_rules;

// The surface near a wall, by place in the wall's frame: its navigation mesh is near it, insects are on it.
class WallSurface {
 public:
  WallSurface(const Pose& wall_from_world, const SurfaceByBlock& surface) {
    const Eigen::Isometry3f to_wall = wall_from_world.cast<float>();
    for (const auto& block : surface) {
      for (const SurfaceSample& sample : block) {
        const Vec3d at = (to_wall * sample.at_m).cast<double>();
        const Vec3d normal = (to_wall.linear() * sample.normal).cast<double>();
        if (std::abs(at.z()) > kNear_m || normal.z() < kFacesOut) continue;
        samples_[cell_of(at)].push_back({at, normal});
      }
    }
  }

  // The place on the surface where a point of the mesh is set down, and how far the nearest sample is from it; the point itself,
  // and kNone_m, where there is none.
  std::pair<Vec3d, double> set_down(const Vec3d& point) const {
    const Sample* nearest = nullptr;
    double least_m = std::numeric_limits<double>::infinity();
    const Cell middle = cell_of(point);
    for (int n = 0; n < 9; ++n) {
      const auto found = samples_.find({middle.first + n % 3 - 1, middle.second + n / 3 - 1});
      if (found == samples_.end()) continue;
      for (const Sample& sample : found->second) {
        const double off_m = (sample.at - point).head<2>().norm();
        if (off_m >= least_m) continue;
        least_m = off_m;
        nearest = &sample;
      }
    }
    if (nearest == nullptr) return {point, kNone_m};
    const Vec3d way = point - nearest->at;
    const Vec3d& n = nearest->normal;
    const Vec3d on(point.x(), point.y(), nearest->at.z() - (n.x() * way.x() + n.y() * way.y()) / n.z());
    return {on, (on - nearest->at).norm()};
  }

 private:
  static constexpr double kNear_m = 0.05;
  static constexpr double kFacesOut = 0.7;
  static constexpr double kCell_m = 0.05;
  static constexpr double kNone_m = 2 * kCell_m;
  using Cell = std::pair<int, int>;
  struct Sample {
    Vec3d at = Vec3d::Zero();
    Vec3d normal = Vec3d::UnitZ();
  };
  static Cell cell_of(const Vec3d& at) {
    return {static_cast<int>(std::floor(at.x() / kCell_m)), static_cast<int>(std::floor(at.y() / kCell_m))};
  }

  std::map<Cell, std::vector<Sample>> samples_;
};

// A wall with what insects need of it.
struct CrawledWall {
  CrawledWall(std::size_t place, const WallMesh& wall, const SurfaceByBlock& samples, const UpFrame& frame)
      : number(place),
        mesh(wall.mesh),
        places(wall.mesh),
        surface(wall.wall_from_grid * frame.grid_from_world, samples),
        grid_from_wall(wall.wall_from_grid.inverse()) {}

  std::size_t number;
  const RecastMesh& mesh;
  MeshPlaces places;
  WallSurface surface;
  Pose grid_from_wall;
};

double wrapped(double angle) { return std::atan2(std::sin(angle), std::cos(angle)); }

// In the frame of its wall, whose z leads out.
class Insect {
 public:
  Insect(const CrawledWall& wall, Dice& dice)
      : wall_(wall),
        dice_(dice),
        place_(wall.places.any(dice)),
        heading_rad_(2 * std::numbers::pi * dice.roll()),
        speed_m_s_(dice.between(rules::kInsectSpeed_m_s)) {}

  void update() {
    rest_s_ -= rules::kStep_s;
    if (rest_s_ > 0) return;
    if (corners_.empty()) return choose();
    const Vec3d way = corners_.front() - place_;
    const double left_m = way.norm();
    if (left_m > kThere_m && !turn(std::atan2(way.y(), way.x()))) return;
    const double step_m = std::min(left_m, speed_m_s_ * rules::kStep_s);
    if (left_m > 0) place_ += way * (step_m / left_m);
    crawled_m_ += step_m;
    if (left_m - step_m > kThere_m) return;
    corners_.pop_front();
    if (corners_.empty()) rest_s_ = dice_.between(rules::kInsectRests_s);
  }

  void note_sample(double time_s, InsectTrack& track) const {
    const auto [on_wall, off_m] = wall_.surface.set_down(place_);
    track.samples.push_back({time_s, wall_.number, wall_.grid_from_wall * on_wall});
    track.crawled_m = crawled_m_;
    track.farthest_m = std::max(track.farthest_m, off_m);
  }

 private:
  static constexpr double kThere_m = 1e-4;

  void choose() {
    for (int i = 0; i < rules::kInsectTries; ++i) {
      const Vec3d to = wall_.places.any(dice_);
      if ((to - place_).head<2>().norm() >= rules::kInsectFarthest_m) continue;
      const auto way = wall_.mesh.way(place_, to);
      if (!way) continue;
      corners_.assign(way->begin() + 1, way->end());
      return;
    }
    rest_s_ = rules::kInsectRests_s.high;
  }

  // False while it is too far off its way to go on.
  bool turn(double wanted_rad) {
    const double off = wrapped(wanted_rad - heading_rad_);
    const double most = rules::kInsectTurn_rad_s * rules::kStep_s;
    heading_rad_ = wrapped(heading_rad_ + std::clamp(off, -most, most));
    return std::abs(off) - most <= rules::kInsectTurnsFirst_rad;
  }

  const CrawledWall& wall_;
  Dice& dice_;
  Vec3d place_;
  double heading_rad_;
  double speed_m_s_;
  double rest_s_ = 0;
  double crawled_m_ = 0;
  std::deque<Vec3d> corners_;
};

std::vector<CrawledWall> crawled_walls(const std::vector<WallMesh>& walls, const SurfaceByBlock& surface, const UpFrame& frame) {
  std::vector<CrawledWall> result;
  for (std::size_t i = 0; i < walls.size() && result.size() < rules::kInsectWalls; ++i) {
    if (walls[i].mesh.has_polygons()) result.emplace_back(i, walls[i], surface, frame);
  }
  return result;
}

}  // namespace

std::vector<InsectTrack> let_crawl(const std::vector<WallMesh>& walls, const SurfaceByBlock& surface, const UpFrame& frame,
                                   const AgentOptions& options) {
  if (options.insects == 0) return {};
  const std::vector<CrawledWall> crawled = crawled_walls(walls, surface, frame);
  if (crawled.empty()) return {};
  constexpr std::uint32_t kOfInsects = 0x9e3779b9U;  // people roll the same numbers, whether there are insects or not
  Dice dice(options.seed ^ kOfInsects);
  std::vector<Insect> insects;
  for (int i = 0; i < options.insects; ++i) insects.emplace_back(crawled[dice.below(crawled.size())], dice);
  std::vector<InsectTrack> tracks(insects.size());
  const auto steps = static_cast<int>(std::floor(options.seconds * rules::kStepsPer_s + 1e-6));
  for (int step = 0; step <= steps; ++step) {
    for (std::size_t i = 0; i < insects.size(); ++i) {
      if (step > 0) insects[i].update();
      if (step % rules::kStepsPerSample == 0) insects[i].note_sample(step * rules::kStep_s, tracks[i]);
    }
  }
  return tracks;
}

}  // namespace panoptic
