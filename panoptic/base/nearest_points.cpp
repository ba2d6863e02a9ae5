// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/nearest_points.h"

#include <cmath>
#include <limits>
#include <nanoflann.hpp>
#include <utility>

namespace panoptic {
namespace {

struct Cloud {
  std::vector<Vec3f> points;

  // The functions that nanoflann asks of a data set, in its names.
  std::size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(std::size_t index, std::size_t axis) const { return points[index][static_cast<Eigen::Index>(axis)]; }
  template <typename Box>
  bool kdtree_get_bbox(Box& /*box*/) const {
    return false;
  }
};

// The nearest point; unlike nanoflann's own result sets, ties do not depend on the order of the search.
struct Nearest {
  using DistanceType = double;

  std::uint32_t index = 0;
  double squared_m2 = std::numeric_limits<double>::infinity();
  bool found = false;

  // nanoflann offers points that are nearer than worstDist().
  // NOLINTBEGIN(readability-identifier-naming)
  double worstDist() const { return found ? std::nextafter(squared_m2, std::numeric_limits<double>::infinity()) : squared_m2; }
  bool full() const { return found; }
  bool addPoint(double squared, std::uint32_t candidate) {
    if (!found || squared < squared_m2 || (squared == squared_m2 && candidate < index)) {
      squared_m2 = squared;
      index = candidate;
      found = true;
    }
    return true;
  }
  // NOLINTEND(readability-identifier-naming)
};

using KdTree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Cloud, double, std::uint32_t>, Cloud, 3,
                                                   std::uint32_t>;

}  // namespace

struct NearestPoints::Tree {
  explicit Tree(std::vector<Vec3f> points)
      : cloud{std::move(points)}, index(3, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafPoints)) {}

  static constexpr std::size_t kLeafPoints = 16;
  Cloud cloud;
  KdTree index;
};

NearestPoints::NearestPoints(std::vector<Vec3f> points) {
  if (!points.empty()) tree_ = std::make_unique<Tree>(std::move(points));
}

NearestPoints::~NearestPoints() = default;

std::optional<NearestPoints::Found> NearestPoints::nearest(const Vec3f& point) const {
  if (tree_ == nullptr) return std::nullopt;
  Nearest nearest;
  tree_->index.findNeighbors(nearest, point.data(), nanoflann::SearchParams());
  return Found{nearest.index, std::sqrt(nearest.squared_m2)};
}

}  // namespace panoptic
