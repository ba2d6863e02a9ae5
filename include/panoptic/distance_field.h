// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The Euclidean signed distance field of a map: how far is the nearest surface, and which way leads away from it. Metres, in the
// z-up frame of the map (planning.h).
//   DistanceField field(up_frame(map));
//   field.update(map);                    // again after every change; it takes as long as the change is large
//   const auto away = field.gradient({1.0, 2.0, 0.5});
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "panoptic/map.h"
#include "panoptic/planning.h"

namespace panoptic {

struct DistanceFieldOptions {
  double cell_m = 0.048;  // of the cells; 0.01 to 1
  double cap_m = 2;       // distances end there; at least one cell, at most 250
};

class DistanceField {
 public:
  // Throws Error if the options are out of range.
  explicit DistanceField(const UpFrame& frame, const DistanceFieldOptions& options = {});
  DistanceField(DistanceField&&) noexcept;
  DistanceField& operator=(DistanceField&&) noexcept;
  DistanceField(const DistanceField&) = delete;
  DistanceField& operator=(const DistanceField&) = delete;
  ~DistanceField();

  // Brings the distances up to date with the map, whose blocks it reads where they changed since the last update (all, the
  // first time). The queries below read the map too: they tell the truth until it changes, and it must outlive them. Throws
  // Error if the map is too large for the cells.
  void update(const PanopticMap& map);

  double cell_m() const;
  double cap_m() const;
  const Pose& grid_from_world() const;

  // From the centre of the cell around the point to the centre of the nearest cell with surface: at most one cell from the
  // distance of that point; negative behind surfaces, nothing where the map knows neither surface nor space.
  std::optional<double> distance_at(const Vec3d& point_m) const;
  // The same, interpolated between the cells around the point. Nothing unless all eight are known.
  std::optional<double> distance_m(const Vec3d& point_m) const;
  // The direction in which the distance grows fastest, unit length. Nothing where it is not known or the same all around.
  std::optional<Vec3d> gradient(const Vec3d& point_m) const;

  // All cells around the surface, x fastest, then y; NaN where nothing is known.
  struct Values {
    Eigen::Vector3i size = Eigen::Vector3i::Zero();
    Vec3d origin_m = Vec3d::Zero();  // the centre of the first cell
    std::vector<float> distance_m;
  };
  Values values() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace panoptic
