// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/views.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <string>
#include <system_error>
#include <vector>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/error.h"
#include "panoptic/io/annotations.h"
#include "panoptic/io/rasterizer.h"
#include "panoptic/outputs.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr std::array kModes = {ColorMode::kColor, ColorMode::kClasses, ColorMode::kPanoptic};
constexpr std::size_t kVerticesPerTask = 16384;
constexpr float kNearest_m = 0.01F;

// Photographs carry the light of the room already; label colours need all of it from here.
struct Light {
  float ambient = 0;
  float sky = 0;   // more where the surface faces up
  float lamp = 0;  // more where it faces the camera
};

constexpr Light kPhotoLight = {0.74F, 0.12F, 0.22F};
constexpr Light kLabelLight = {0.44F, 0.18F, 0.40F};

Rgb color_of_vertex(const MeshVertex& vertex, ColorMode mode, const LabelSet& labels) {
  const auto id = mode == ColorMode::kClasses ? LabelSet::id_of_class(vertex.class_id) : vertex.panoptic_id;
  return mode == ColorMode::kColor ? vertex.color : picture_color(id, labels);
}

Drawing drawing_of(const Mesh& mesh, const View& view, ColorMode mode, const LabelSet& labels) {
  Drawing drawing{view.camera.width, view.camera.height, mode != ColorMode::kColor,
                  std::vector<DrawnVertex>(mesh.vertices.size()), &mesh.triangles};
  const Pose camera_from_world = view.world_from_camera.inverse();
  const Eigen::Matrix3f rotation = camera_from_world.linear().cast<float>();
  const Vec3f up = rotation * view.up.cast<float>();
  const Light light = mode == ColorMode::kColor ? kPhotoLight : kLabelLight;
  const Camera& camera = view.camera;
  const std::size_t count = mesh.vertices.size();
  parallel_for((count + kVerticesPerTask - 1) / kVerticesPerTask, [&](std::size_t task) {
    for (std::size_t i = task * kVerticesPerTask; i < std::min(count, (task + 1) * kVerticesPerTask); ++i) {
      const MeshVertex& vertex = mesh.vertices[i];
      DrawnVertex& drawn = drawing.vertices[i];
      const Vec3d p = camera_from_world * vertex.position.cast<double>();
      if (!(p.z() > kNearest_m)) continue;
      drawn.at = Vec3d(camera.fx * p.x() / p.z() + camera.cx, camera.fy * p.y() / p.z() + camera.cy, 1 / p.z()).cast<float>();
      const Vec3f normal = rotation * vertex.normal;
      const float facing = std::clamp(-normal.dot(p.cast<float>().normalized()), 0.0F, 1.0F);
      drawn.shade = light.ambient + light.sky * 0.5F * (1 + normal.dot(up)) + light.lamp * facing;
      if (!std::isfinite(drawn.shade)) drawn.shade = light.ambient;  // a vertex without a normal
      drawn.color = color_of_vertex(vertex, mode, labels);
      drawn.label = mode == ColorMode::kClasses ? number(vertex.class_id) : number(vertex.panoptic_id);
    }
  });
  return drawing;
}

}  // namespace

std::string_view name_of(ColorMode mode) {
  switch (mode) {
    case ColorMode::kColor:
      return "color";
    case ColorMode::kClasses:
      return "classes";
    default:
      return "panoptic";
  }
}

Image<Rgb> render(const Mesh& mesh, const View& view, ColorMode mode, const LabelSet& labels) {
  Picture picture = rasterize(drawing_of(mesh, view, mode, labels));
  if (mode == ColorMode::kClasses) draw_class_legend(picture, labels);
  if (mode == ColorMode::kPanoptic) draw_object_names(picture, mesh, labels);
  return std::move(picture.color);
}

void remove_views(const std::filesystem::path& folder) {
  std::error_code failed;
  for (const std::string_view view : kViewNames) {
    for (const ColorMode mode : kModes) {
      const std::filesystem::path picture = folder / fmt::format("{}_{}.png", view, name_of(mode));
      std::filesystem::remove(picture, failed);
      if (failed) throw Error(fmt::format("{}: an older picture cannot be removed: {}", picture.string(), failed.message()));
    }
  }
  std::filesystem::remove(folder, failed);  // stays if it holds anything else
}

void write_views(const std::filesystem::path& folder, const Mesh& mesh, const Vec3d& up, const LabelSet& labels) {
  require_writable_folder(folder);
  for (const View& view : default_views(mesh, up)) {
    for (const ColorMode mode : kModes) {
      write_png(folder / fmt::format("{}_{}.png", view.name, name_of(mode)), render(mesh, view, mode, labels));
    }
  }
}

}  // namespace panoptic
