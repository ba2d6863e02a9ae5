// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/views.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "panoptic/base/image_io.h"
#include "panoptic/error.h"
#include "panoptic/outputs.h"
#include "panoptic/parallel.h"
#include "tests/fresh_folder.h"
#include "tests/io/test_room.h"

namespace panoptic {
namespace {

using ::testing::ElementsAre;

const Vec3d kUp = {0, -1, 0};

// Where the view shows a point: u, v in pixels.
Eigen::Vector2d seen_at(const View& view, const Vec3f& point) {
  const Vec3d p = view.world_from_camera.inverse() * point.cast<double>();
  EXPECT_GT(p.z(), 0);
  return {view.camera.fx * p.x() / p.z() + view.camera.cx, view.camera.fy * p.y() / p.z() + view.camera.cy};
}

// The share of the picture's pixels that are nearly this colour.
double share_like(const Image<Rgb>& image, const Rgb& color) {
  const auto near = [](int a, int b) { return std::abs(a - b) < 40; };
  std::size_t count = 0;
  for (const Rgb& c : image.pixels()) count += near(c.r, color.r) && near(c.g, color.g) && near(c.b, color.b) ? 1 : 0;
  return static_cast<double>(count) / static_cast<double>(image.size());
}

Mesh turned(Mesh mesh, const Eigen::Matrix3f& rotation) {
  for (MeshVertex& vertex : mesh.vertices) {
    vertex.position = rotation * vertex.position;
    vertex.normal = rotation * vertex.normal;
  }
  return mesh;
}

TEST(Views, ThreeViewsShowAllOfTheRoomAndFillThePicture) {
  const Eigen::Matrix3f tilt = Eigen::AngleAxisf(0.7F, Vec3f(1, 2, 3).normalized()).toRotationMatrix();
  for (const Eigen::Matrix3f& rotation : {Eigen::Matrix3f(Eigen::Matrix3f::Identity()), tilt}) {
    const Mesh room = turned(test::room(0.1F), rotation);
    const std::vector<View> views = default_views(room, rotation.cast<double>() * kUp);
    ASSERT_EQ(views.size(), 3U);
    for (const View& view : views) {
      EXPECT_TRUE(is_rigid(view.world_from_camera, 1e-9));
      Eigen::AlignedBox2d box;
      for (const MeshVertex& vertex : room.vertices) box.extend(seen_at(view, vertex.position));
      EXPECT_GE(box.min().minCoeff(), 0) << view.name;
      EXPECT_LE(box.max().x(), view.camera.width - 1) << view.name;
      EXPECT_LE(box.max().y(), view.camera.height - kLegendRows_px) << view.name;
      EXPECT_TRUE(box.sizes().x() > 0.9 * view.camera.width || box.sizes().y() > 0.9 * (view.camera.height - kLegendRows_px))
          << view.name;
    }
  }
}

TEST(Views, TwoLookDownFromOppositeSidesAndOneFromAbove) {
  const std::vector<View> views = default_views(test::room(0.1F), 5 * kUp);
  const auto forward = [&](std::size_t i) -> Vec3d { return views[i].world_from_camera.linear().col(2); };
  EXPECT_EQ(views[0].name + views[1].name + views[2].name, "frontsidetop");
  for (const std::size_t i : {0U, 1U}) {
    EXPECT_NEAR(std::asin(-forward(i).dot(kUp)), 40 * std::numbers::pi / 180, 1e-6);
    EXPECT_GT(-views[i].world_from_camera.linear().col(1).dot(kUp), 0.7) << "upside down";
  }
  const auto level = [&](std::size_t i) { return Vec3d(forward(i) - forward(i).dot(kUp) * kUp).normalized(); };
  EXPECT_LT(level(0).dot(level(1)), -0.45);
  EXPECT_TRUE(forward(2).isApprox(-kUp, 1e-9));
  EXPECT_NEAR(std::abs(views[2].world_from_camera.linear().col(0).x()), 1, 1e-3) << "the long side of the room lies across";
}

TEST(Views, AFewStrayVerticesDoNotMoveTheCameraAway) {
  Mesh mesh = test::room(0.1F);
  const std::vector<View> before = default_views(mesh, kUp);
  test::add_sheet(mesh, {500, 0, 500}, {0.01F, 0, 0}, {0, 0.01F, 0}, test::paint({0, 0, 0}, 0, 0), 1);
  const std::vector<View> after = default_views(mesh, kUp);
  for (std::size_t i = 0; i < before.size(); ++i) {
    const Vec3d moved = after[i].world_from_camera.translation() - before[i].world_from_camera.translation();
    EXPECT_LT(moved.norm(), 0.35 * before[i].world_from_camera.translation().norm()) << before[i].name;
  }
}

TEST(Views, ARoomIsSeenThroughItsNearWalls) {
  const LabelSet labels = test::room_labels();
  const Mesh room = test::room(0.1F);
  for (const View& view : default_views(room, kUp)) {
    const Image<Rgb> image = render(room, view, ColorMode::kClasses, labels);
    EXPECT_GT(share_like(image, labels.find("floor")->color), 0.15) << view.name;
    EXPECT_GT(share_like(image, labels.find("dining table")->color), 0.015) << view.name;
  }
}

TEST(Views, EachModeShowsItsColors) {
  const LabelSet labels = test::room_labels();
  const Mesh room = test::room(0.1F);
  const View top = default_views(room, kUp)[2];
  const Rgb carpet = {125, 94, 62};
  EXPECT_GT(share_like(render(room, top, ColorMode::kColor, labels), carpet), 0.2);
  EXPECT_LT(share_like(render(room, top, ColorMode::kClasses, labels), carpet), 0.02);
  const Image<Rgb> panoptic = render(room, top, ColorMode::kPanoptic, labels);
  for (const int id : {5, 6, 7}) {
    const Rgb color = color_of(static_cast<PanopticId>(id), labels);

    EXPECT_GT(share_like(panoptic, color), 0.003) << id;
  }
  const Image<Rgb> classes = render(room, top, ColorMode::kClasses, labels);
  EXPECT_LT(share_like(classes, color_of(static_cast<PanopticId>(6), labels)), 0.001) << "both chairs have the colour of chairs";
}

TEST(Views, ClassesAreExplainedBelowThePicture) {
  const LabelSet labels = test::room_labels();
  const Mesh room = test::room(0.1F);
  const View top = default_views(room, kUp)[2];
  const Image<Rgb> image = render(room, top, ColorMode::kClasses, labels);
  std::set<std::string> swatches;
  for (int v = image.height() - kLegendRows_px; v < image.height(); ++v) {
    for (int u = 0; u < image.width(); ++u) {
      for (const LabelClass& c : labels.classes()) {
        if (image(u, v) == c.color) swatches.insert(c.name);
      }
    }
  }
  EXPECT_THAT(swatches, ElementsAre("chair", "dining table", "floor", "wall"));
}

TEST(Views, OneThreadAndTwoDrawTheSamePicture) {
  const LabelSet labels = test::room_labels();
  const Mesh room = test::room(0.05F);
  const View view = default_views(room, kUp)[0];
  for (const ColorMode mode : {ColorMode::kColor, ColorMode::kPanoptic}) {
    set_thread_count(1);
    const Image<Rgb> one = render(room, view, mode, labels);
    set_thread_count(2);
    const Image<Rgb> two = render(room, view, mode, labels);
    set_thread_count(0);
    EXPECT_EQ(one, two);
  }
}

TEST(Views, OddMeshesGivePicturesToo) {
  const LabelSet labels = test::room_labels();
  Mesh point;
  point.vertices.push_back({{1, 2, 3}, Vec3f::Zero(), {}, ClassId::kUnknown, PanopticId::kUnknown});
  point.triangles.push_back({0, 0, 0});
  Mesh broken = test::room(0.5F);
  broken.vertices[3].position.x() = std::numeric_limits<float>::quiet_NaN();
  broken.vertices[9].normal = Vec3f::Constant(std::numeric_limits<float>::quiet_NaN());
  for (const Mesh& mesh : {Mesh{}, point, broken}) {
    for (const Vec3d& up : {Vec3d(0, 0, 0), Vec3d(0, 0, 1), Vec3d(std::numeric_limits<double>::quiet_NaN(), 0, 0)}) {
      for (const View& view : default_views(mesh, up)) {
        ASSERT_TRUE(is_rigid(view.world_from_camera, 1e-6)) << view.name;
        EXPECT_TRUE(render(mesh, view, ColorMode::kPanoptic, labels).same_size(1280, 960));
      }
    }
  }
}

TEST(Views, NinePicturesAreWritten) {
  const auto folder = test::fresh_folder("views") / "views";
  write_views(folder, test::room(0.2F), kUp, test::room_labels());
  for (const char* view : {"front", "side", "top"}) {
    for (const char* mode : {"color", "classes", "panoptic"}) {
      const auto path = folder / (std::string(view) + "_" + mode + ".png");
      EXPECT_TRUE(read_rgb(path).same_size(1280, 960)) << path;
    }
  }
}

TEST(Views, AFileInPlaceOfTheFolderIsAnError) {
  const auto folder = test::fresh_folder("views_blocked");
  write_png(folder / "views", Image<Rgb>(1, 1));
  EXPECT_THROW(write_views(folder / "views", test::room(0.5F), kUp, test::room_labels()), Error);
}

}  // namespace
}  // namespace panoptic
