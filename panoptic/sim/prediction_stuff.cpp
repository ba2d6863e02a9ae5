// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/prediction_stuff.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

namespace panoptic {
namespace {

constexpr std::uint64_t kLostPurpose = 0x5331;
constexpr std::uint64_t kTakenPurpose = 0x5332;
constexpr int kStep_px = 8;  // patches are much larger
constexpr double kFloorHeight_m = 0.15;

ClassId stuff_of(const LabelSet& labels, std::string_view name) {
  const LabelClass* found = labels.find(name);
  return found != nullptr && !found->is_thing ? found->id : ClassId::kUnknown;
}

// A standard normal number per pixel, from smooth noise at the surface point that the pixel sees and from noise of this frame.
Image<float> patch_field(const Observation& o, std::uint64_t purpose) {
  const Image<float>& depth = o.frame.rendering.depth;
  const double patch_m = static_cast<double>(o.noise.patch_m);
  const double lasting = std::min(1.0, static_cast<double>(o.noise.object_share) + static_cast<double>(o.noise.view_share));
  const std::uint64_t place_seed = hash_bits(o.seed, purpose);
  const std::uint64_t frame_seed = hash_bits(o.seed, purpose, ~o.frame_number());
  Image<float> grid((depth.width() - 1) / kStep_px + 2, (depth.height() - 1) / kStep_px + 2);
  for (int row = 0; row < grid.height(); ++row) {
    for (int column = 0; column < grid.width(); ++column) {
      const int u = std::min(column * kStep_px, depth.width() - 1);
      const int v = std::min(row * kStep_px, depth.height() - 1);
      const Vec3d in_camera = back_project(o.frame.frame.color_camera, u, v, static_cast<double>(depth(u, v)));
      const Vec3d point = o.frame.true_world_from_camera * in_camera / patch_m;
      grid(column, row) = static_cast<float>(std::sqrt(lasting) * smooth_noise(place_seed, point) +
                                             std::sqrt(1 - lasting) * smooth_noise(frame_seed, point));
    }
  }
  Image<float> field(depth.width(), depth.height());
  add_interpolated(grid, kStep_px, field);
  return field;
}

// Decides the class of a pixel by its two fields.
class StuffRule {
 public:
  explicit StuffRule(const Observation& o)
      : wall_(stuff_of(o.labels, "wall")),
        floor_(stuff_of(o.labels, "floor")),
        other_(o.labels.first_thing(), ClassId::kUnknown),
        lost_below_(static_cast<float>(normal_quantile(static_cast<double>(o.noise.stuff_lost)))),
        swapped_below_(static_cast<float>(normal_quantile(static_cast<double>(o.noise.stuff_swapped)))),
        taken_above_(static_cast<float>(-normal_quantile(static_cast<double>(o.noise.things_as_stuff)))) {
    for (const LabelClass& c : o.labels.classes()) {
      if (!c.is_thing) other_[number(c.id)] = c.id == wall_ ? floor_ : (c.id == floor_ ? wall_ : c.id);
    }
  }

  // `height_m` gives the pixel's height above the floor.
  template <typename Height>
  ClassId apply(ClassId truth, float lost, float taken, const Height& height_m) const {
    const bool is_stuff = number(truth) < other_.size() && other_[number(truth)] != ClassId::kUnknown;
    if (is_stuff) return lost < lost_below_ ? ClassId::kUnknown : (taken < swapped_below_ ? other_[number(truth)] : truth);
    if (taken <= taken_above_) return truth;
    return height_m() < kFloorHeight_m ? floor_ : wall_;
  }

 private:
  ClassId wall_;
  ClassId floor_;
  std::vector<ClassId> other_;  // by class: what stuff is taken for; kUnknown for things and void
  float lost_below_;
  float swapped_below_;
  float taken_above_;
};

}  // namespace

Image<ClassId> noisy_semantic(const Observation& o, const DisplacementField& field) {
  const Rendering& r = o.frame.rendering;
  const bool patches = std::max({o.noise.stuff_lost, o.noise.stuff_swapped, o.noise.things_as_stuff}) > 0;
  if (!patches && o.noise.boundary_px <= 0) return r.class_id;
  const StuffRule rule(o);
  const Image<float> lost = patches ? patch_field(o, kLostPurpose) : Image<float>(r.depth.width(), r.depth.height());
  const Image<float> taken = patches ? patch_field(o, kTakenPurpose) : lost;
  const Eigen::RowVector3d up = o.frame.true_world_from_camera.linear().row(2);
  const double eye_height_m = o.frame.true_world_from_camera.translation().z();
  const int width = r.depth.width();
  const int height = r.depth.height();
  Image<ClassId> semantic(width, height);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const std::size_t pixel = static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u);
      const auto [from_u, from_v] = field.other_source(u, v, o.noise.boundary_px);
      const auto height_m = [&, u_of = from_u, v_of = from_v] {
        return eye_height_m +
               up.dot(back_project(o.frame.frame.color_camera, u_of, v_of, static_cast<double>(r.depth(u_of, v_of))));
      };
      semantic[pixel] = rule.apply(r.class_id(from_u, from_v), lost[pixel], taken[pixel], height_m);
    }
  }
  return semantic;
}

}  // namespace panoptic
