// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Tells where one may stand in a simulated home: its furniture and walls as triangles, and the floor that frames saw.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "panoptic/planning/columns.h"
#include "panoptic/planning/distance_cells.h"
#include "panoptic/sim/home.h"
#include "panoptic/sim/renderer.h"
#include "tests/planning/true_points.h"

namespace panoptic::test {

class HomeTruth {
 public:
  static constexpr double kCell_m = 0.024;

  // Everything between the two heights is in the way.
  HomeTruth(const Home& home, double low_m, double high_m)
      : obstacles_(kReach_cells), unfit_(kReach_cells), low_m_(low_m), high_m_(high_m) {
    Eigen::AlignedBox2d all;
    for (const Room& room : home.rooms) all.extend(room.floor);
    grid_ = {kCell_m};
    grid_.low = grid_.around(all.min()) - Eigen::Vector2i::Constant(20);
    grid_.size = grid_.around(all.max()) - grid_.low + Eigen::Vector2i::Constant(21);
    seen_.assign(grid_.count(), 0);
    obstacles_.cover({Cell(grid_.low.x(), grid_.low.y(), 0), Cell(grid_.size.x(), grid_.size.y(), 1)});
    unfit_.cover({Cell(grid_.low.x(), grid_.low.y(), 0), Cell(grid_.size.x(), grid_.size.y(), 1)});
    for (const SceneObject& object : home.scene.objects) add(home.scene, object);
  }

  // The floor that a frame saw, from its true depth and classes.
  void see(const Rendering& rendering, const Camera& camera, const Pose& home_from_camera, ClassId floor) {
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        if (rendering.class_id(u, v) != floor || !(rendering.depth(u, v) > 0)) continue;
        const Vec3d p = home_from_camera * back_project(camera, u, v, double{rendering.depth(u, v)});
        const Eigen::Vector2i spot = grid_.around(p.head<2>());
        for (int n = 0; n < 4; ++n) {  // the coarse cell of four
          const Eigen::Vector2i fine((spot.x() & ~1) + (n & 1), (spot.y() & ~1) + (n >> 1));
          if (grid_.contains(fine)) seen_[grid_.index(fine)] = 1;
        }
      }
    }
  }

  void finish() {
    obstacles_.update();
    for (std::size_t i = 0; i < grid_.count(); ++i) {
      const Cell cell(grid_.at(i).x(), grid_.at(i).y(), 0);
      if (seen_[i] == 0 || obstacles_.holds(cell)) unfit_.add(cell);
    }
    unfit_.update();
  }

  // Metres from the nearest obstacle, and from the nearest place that is no floor that was seen; at most 1.2.
  double clearance_m(const Eigen::Vector2d& at) const { return distance_m(obstacles_, at); }
  double floor_clearance_m(const Eigen::Vector2d& at) const { return distance_m(unfit_, at); }

  Eigen::AlignedBox2d extent() const {
    return {grid_.low.cast<double>() * kCell_m, (grid_.low + grid_.size).cast<double>() * kCell_m};
  }

 private:
  static constexpr int kReach_cells = 50;

  double distance_m(const DistanceCells& cells, const Eigen::Vector2d& at) const {
    const Eigen::Vector2i spot = grid_.around(at);
    if (!grid_.contains(spot)) return 0;
    const std::uint16_t squared = cells.squared({spot.x(), spot.y(), 0});
    return kCell_m * (squared == DistanceCells::kFar ? kReach_cells : std::sqrt(static_cast<double>(squared)));
  }

  void add(const Scene& scene, const SceneObject& object) {
    for_points_of(scene, object, low_m_, high_m_, kCell_m / 2, [&](const Vec3d& p) {
      const Eigen::Vector2i spot = grid_.around(p.head<2>());
      const Cell cell(spot.x(), spot.y(), 0);
      if (grid_.contains(spot) && !obstacles_.holds(cell)) obstacles_.add(cell);
    });
  }

  GroundGrid grid_;
  DistanceCells obstacles_;
  DistanceCells unfit_;
  std::vector<std::uint8_t> seen_;
  double low_m_;
  double high_m_;
};

}  // namespace panoptic::test
