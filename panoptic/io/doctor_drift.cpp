// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/doctor_drift.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "panoptic/data/motion.h"
#include "panoptic/io/doctor_sample.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr double kFarthest_m = 0.3;
constexpr double kScale_m = 0.03;     // of Cauchy's weights
constexpr std::size_t kFewest = 300;  // points on one surface
constexpr std::size_t kFewestPairs = 3;
constexpr double kVoxel_m = 0.024;  // as maps have it: what is farther off makes walls thick, and then two of one

// A point of `from` in the camera of `to`, and the plane that it should lie on.
struct OnPlane {
  Vec3d point;
  Vec3d normal;
  double off_m = 0;  // signed, along the normal
};

Vec3d point_at(const DepthView& view, int u, int v) {
  return back_project(view.camera, u, v, static_cast<double>(view.depth(u, v)));
}

// The normal from the neighbours' readings; nothing at edges.
std::optional<Vec3d> normal_at(const DepthView& view, int u, int v) {
  constexpr float kEdge = 0.05F;  // of the depth
  if (u < 1 || v < 1 || u + 1 >= view.camera.width || v + 1 >= view.camera.height) return std::nullopt;
  const float depth = view.depth(u, v);
  for (const float beside : {view.depth(u - 1, v), view.depth(u + 1, v), view.depth(u, v - 1), view.depth(u, v + 1)}) {
    if (!(std::abs(beside - depth) < kEdge * depth)) return std::nullopt;
  }
  const Vec3d normal =
      (point_at(view, u, v + 1) - point_at(view, u, v - 1)).cross(point_at(view, u + 1, v) - point_at(view, u - 1, v));
  return normal.norm() > 0 ? std::optional<Vec3d>(normal.normalized()) : std::nullopt;
}

std::optional<OnPlane> on_plane(const ViewPair& pair, const Pose& to_from, int u, int v) {
  if (!(pair.from.depth(u, v) > 0)) return std::nullopt;
  const Vec3d point = to_from * point_at(pair.from, u, v);
  if (!(point.z() > 0)) return std::nullopt;
  const Camera& camera = pair.to.camera;
  const double x = std::round(camera.fx * point.x() / point.z() + camera.cx);
  const double y = std::round(camera.fy * point.y() / point.z() + camera.cy);
  if (!(x >= 0 && y >= 0 && x < camera.width && y < camera.height)) return std::nullopt;
  const auto normal = normal_at(pair.to, static_cast<int>(x), static_cast<int>(y));
  if (!normal) return std::nullopt;
  const double off_m = normal->dot(point - point_at(pair.to, static_cast<int>(x), static_cast<int>(y)));
  return std::abs(off_m) < kFarthest_m ? std::optional<OnPlane>({point, *normal, off_m}) : std::nullopt;
}

std::vector<OnPlane> all_on_planes(const ViewPair& pair, const Pose& to_from) {
  constexpr int kStep = 2;
  std::vector<OnPlane> points;
  for (int v = 0; v < pair.from.camera.height; v += kStep) {
    for (int u = 0; u < pair.from.camera.width; u += kStep) {
      if (const auto point = on_plane(pair, to_from, u, v)) points.push_back(*point);
    }
  }
  return points;
}

// The small motion that brings the points to their planes. What no plane holds stays as it is.
Pose step_to_planes(const std::vector<OnPlane>& points) {
  Matrix6d a = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
  for (const OnPlane& p : points) {
    const double weight = 1 / (1 + p.off_m * p.off_m / (kScale_m * kScale_m));
    Vector6d row;
    row << p.normal, p.point.cross(p.normal);
    a += weight * row * row.transpose();
    b -= weight * p.off_m * row;
  }
  constexpr double kHeld = 0.01;  // of the points
  a.diagonal().array() += kHeld * static_cast<double>(points.size());
  return moved_by(a.ldlt().solve(b));
}

struct Look {
  DepthView view;
  double time_s = 0;
};

std::optional<Look> look_at(const Dataset& dataset, std::size_t position) {
  const ReadResult read = dataset.read(position);
  if (!read.frame || !check(*read.frame).used) return std::nullopt;
  return Look{thinned(*read.frame, repaired(read.frame->depth_camera)), read.frame->time_s};
}

bool look_at_one_place(const Pose& a, const Pose& b) {
  constexpr double kNear_m = 1.5;
  constexpr double kSameWay = 0.8;  // the cosine of 37 degrees
  return (a.translation() - b.translation()).norm() < kNear_m && a.linear().col(2).dot(b.linear().col(2)) > kSameWay;
}

std::vector<float> distances(const std::vector<ViewPair>& pairs) {
  std::vector<std::optional<double>> found(pairs.size());
  parallel_for(pairs.size(), [&](std::size_t i) { found[i] = surfaces_apart_m(pairs[i]); });
  std::vector<float> apart;
  for (const auto& distance : found) {
    if (distance) apart.push_back(static_cast<float>(*distance));
  }
  return apart;
}

}  // namespace

std::optional<double> surfaces_apart_m(const ViewPair& pair) {
  constexpr int kSteps = 8;
  const Pose declared = pair.to.pose.inverse() * pair.from.pose;
  Pose fitted = declared;
  std::vector<OnPlane> points = all_on_planes(pair, fitted);
  for (int step = 0; step < kSteps && points.size() >= kFewest; ++step) {
    fitted = step_to_planes(points) * fitted;
    points = all_on_planes(pair, fitted);
  }
  if (points.size() < kFewest) return std::nullopt;
  const Pose back = declared * fitted.inverse();
  double sum_m = 0;
  for (const OnPlane& p : points) sum_m += std::abs(p.normal.dot(p.point - back * p.point));
  return sum_m / static_cast<double>(points.size());
}

Revisits find_revisits(const Dataset& dataset, std::size_t frames) {
  constexpr std::size_t kMostPairs = 200;
  std::vector<std::optional<Look>> looks(std::min(frames, dataset.size()));
  std::vector<std::optional<Look>> next(looks.size());
  parallel_for(looks.size(), [&](std::size_t i) {
    const std::size_t position = i * dataset.size() / looks.size();
    looks[i] = look_at(dataset, position);
    if (position + 1 < dataset.size()) next[i] = look_at(dataset, position + 1);
  });
  std::vector<std::pair<std::size_t, std::size_t>> revisits;
  std::vector<ViewPair> soon;
  for (std::size_t i = 0; i < looks.size(); ++i) {
    if (looks[i] && next[i]) soon.push_back({next[i]->view, looks[i]->view});
    for (std::size_t k = i + 1; k < looks.size() && looks[i]; ++k) {
      const bool is_later = looks[k] && looks[k]->time_s - looks[i]->time_s >= kLater_s;
      if (is_later && look_at_one_place(looks[i]->view.pose, looks[k]->view.pose)) revisits.emplace_back(i, k);
    }
  }
  std::vector<ViewPair> later;
  const std::size_t count = std::min(revisits.size(), kMostPairs);
  for (std::size_t n = 0; n < count; ++n) {
    const auto [i, k] = revisits[n * revisits.size() / count];
    later.push_back({looks[k]->view, looks[i]->view});
  }
  return {distances(later), distances(soon)};
}

Check check_drift(const Revisits& revisits) {
  Check check{"drift", Verdict::kOk, "", ""};
  if (revisits.later.size() < kFewestPairs || revisits.soon.size() < kFewestPairs) {
    check.evidence =
        fmt::format("hardly anything is seen again after {:g} s or more: drift of the poses would not show", kLater_s);
    return check;
  }
  const double later_m = median(revisits.later);
  const double soon_m = median(revisits.soon);
  check.evidence = fmt::format(
      "surfaces that are seen again after {:g} s or more lie {:.1f} cm off (median of {} pairs of frames; {:.1f} cm in "
      "neighbouring frames)",
      kLater_s, 100 * later_m, revisits.later.size(), 100 * soon_m);
  if (later_m > kVoxel_m && later_m > 3 * soon_m) {
    check.verdict = Verdict::kWarning;
    check.remedy = "walls will be thick, or there twice: correct the poses by loops (rebuild --poses), or try --track";
  }
  return check;
}

}  // namespace panoptic
