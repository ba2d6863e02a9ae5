// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/view_log.h"

#include <cmath>

#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr int kWidth = 80;
constexpr int kHeight = 60;

}  // namespace

ViewLog::ViewLog(const Renderer& renderer, std::size_t objects, const std::vector<Pose>& path, const Camera& camera,
                 std::size_t stride)
    : camera_(resized(camera, kWidth, kHeight)), views_((path.size() + stride - 1) / stride) {
  parallel_for(views_.size(), [&](std::size_t i) {
    SmallView& view = views_[i];
    view.frame = i * stride;
    view.world_from_camera = path[view.frame];
    view.pixels.assign(objects, 0);
    view.near.assign(objects, 0);
    Glance glance = renderer.look(camera_, view.world_from_camera);
    for (std::size_t p = 0; p < glance.depth.size(); ++p) {
      if (glance.depth[p] <= 0) continue;
      ++view.pixels[glance.object[p]];
      if (static_cast<double>(glance.depth[p]) < kShown_m) ++view.near[glance.object[p]];
    }
    view.depth = std::move(glance.depth);
  });
}

int ViewLog::enough_px() const { return static_cast<int>(kEnoughOfPicture * kWidth * kHeight); }

ViewLog::Points ViewLog::points_in(const SmallView& view, const Eigen::AlignedBox3d& box) const {
  constexpr double kBehind_m = 0.1;  // the pictures are coarse
  Points points;
  const Pose camera_from_world = view.world_from_camera.inverse();
  for (int i = 0; i < 27; ++i) {
    const Vec3d share(i % 3 / 2.0, i / 3 % 3 / 2.0, i / 9 / 2.0);
    const Vec3d p = camera_from_world * Vec3d(box.min() + box.sizes().cwiseProduct(share));
    if (p.z() < 0.1) continue;
    const auto u = static_cast<int>(std::lround(camera_.fx * p.x() / p.z() + camera_.cx));
    const auto v = static_cast<int>(std::lround(camera_.fy * p.y() / p.z() + camera_.cy));
    if (u < 0 || v < 0 || u >= camera_.width || v >= camera_.height) continue;
    const auto depth_m = static_cast<double>(view.depth(u, v));
    if (depth_m > 0 && p.z() > depth_m + kBehind_m) continue;
    ++points.seen;
    if (p.z() < kShown_m) ++points.near;
  }
  return points;
}

}  // namespace panoptic
