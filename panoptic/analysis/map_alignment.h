// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// How two maps of one place lie to each other, from constellations of objects: pairs of objects of the same two classes at the
// same distance tell a turn about the vertical and a shift; what most pairs agree on is moved until the surfaces meet (point to
// plane, Chen and Medioni 1991), and judged by what each map says of the other's surface. align_maps of map_pairs.h is made of
// these steps.
#pragma once

#include <vector>

#include "panoptic/analysis/surface_points.h"
#include "panoptic/base/nearest_points.h"
#include "panoptic/labels.h"

namespace panoptic {

// An object where it lies in a world with z up.
struct Landmark {
  ClassId class_id = ClassId::kUnknown;
  Vec3d at = Vec3d::Zero();  // the mean of its surface
};

// Poses a from b that pairs of landmarks ask for, those that most of them agree on first, at most `most`. REQUIRES z up in both.
std::vector<Pose> poses_by_constellations(const std::vector<Landmark>& a, const std::vector<Landmark>& b, std::size_t most);

// A pose, and how firmly the surface holds it.
struct SurfaceFit {
  Pose a_from_b = Pose::Identity();
  // The direction of motion, of six, that the surface holds least: 0 if b can slide along a without leaving it, as along a
  // bare corridor; 1/3 for a ball seen from all sides.
  double least_hold = 0;
};

// Points to fit others to. Threads may share it.
class FitTarget {
 public:
  explicit FitTarget(std::vector<PlacedNormal> points);

  // The nearest point within the radius; nullptr if there is none, or if its normal is more than 60 degrees off.
  const PlacedNormal* find(const PlacedNormal& point, double radius_m) const;

 private:
  std::vector<PlacedNormal> points_;
  NearestPoints nearest_;
};

// Moves b until its points lie on the planes of the nearest points of a, from `start` on; points farther than the radius from any
// do not count.
SurfaceFit fitted(const FitTarget& a, double radius_m, const std::vector<PlacedNormal>& b, const Pose& start, int steps);

}  // namespace panoptic
