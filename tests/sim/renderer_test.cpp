// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/renderer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "panoptic/parallel.h"
#include "panoptic/sim/random.h"
#include "panoptic/sim/surfaces.h"
#include "tests/expect_error.h"
#include "tests/sim/box_room.h"

namespace panoptic {
namespace {

using test::box_room;
using test::looking;
using test::small_camera;
using testing::HasSubstr;

struct NaiveHit {
  double depth = std::numeric_limits<double>::infinity();
  double cosine = 0;
  const SceneObject* object = nullptr;
};

// Every triangle, one after the other, in double precision: solve origin + depth * direction = point of the triangle.
NaiveHit naive_hit(const Scene& scene, const Surfaces& surfaces, const Vec3d& origin, const Vec3d& direction) {
  NaiveHit nearest;
  for (std::size_t t = 0; t < surfaces.triangles.size(); ++t) {
    const auto corner = [&](int i) -> Vec3d { return surfaces.positions[surfaces.triangles[t][i]].cast<double>(); };
    Eigen::Matrix3d columns;
    columns << corner(1) - corner(0), corner(2) - corner(0), -direction;
    if (std::abs(columns.determinant()) < 1e-12) continue;
    const Vec3d solution = columns.inverse() * (origin - corner(0));
    const bool is_inside = solution.x() >= 0 && solution.y() >= 0 && solution.x() + solution.y() <= 1;
    if (!is_inside || solution.z() <= 0 || solution.z() >= nearest.depth) continue;
    const Vec3d normal = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
    nearest = {solution.z(), std::abs(normal.dot(direction.normalized())), &scene.objects[surfaces.origins[t].object]};
  }
  return nearest;
}

double naive_distance(const Surfaces& surfaces, std::size_t t, const Vec3d& p) {
  // The distance over a triangle is convex: nested golden-section-like search by thirds, first along one edge, then the other.
  const auto corner = [&](int i) -> Vec3d { return surfaces.positions[surfaces.triangles[t][i]].cast<double>(); };
  const auto search = [](auto distance, double high) {
    double low = 0;
    for (int i = 0; i < 45; ++i) {
      const double third = (high - low) / 3;
      if (distance(low + third) < distance(high - third)) {
        high -= third;
      } else {
        low += third;
      }
    }
    return distance((low + high) / 2);
  };
  const auto along_u = [&](double u) {
    return search([&](double v) { return (corner(0) + u * (corner(1) - corner(0)) + v * (corner(2) - corner(0)) - p).norm(); },
                  1 - u);
  };
  return search(along_u, 1.0);
}

Pose across_the_room() { return looking({0.3, 0.3, 1.5}, {2.2, 1.9, 0.6}); }

TEST(Renderer, SeesWhatALoopOverAllTrianglesSees) {
  const Scene scene = box_room();
  const Surfaces surfaces = flatten(scene);
  const Renderer renderer(scene);
  const Camera camera = small_camera();
  int hits = 0;
  int misses = 0;
  for (const Pose& pose : {across_the_room(), looking({0.4, 2.7, 1.4}, {4.0, 1.4, 1.5})}) {
    const Rendering rendering = renderer.render(camera, pose);
    for (int v = 3; v < camera.height; v += 9) {
      for (int u = 2; u < camera.width; u += 7) {
        const NaiveHit hit = naive_hit(scene, surfaces, pose.translation(), pose.linear() * back_project(camera, u, v, 1));
        if (hit.object == nullptr) {
          ++misses;
          EXPECT_EQ(rendering.depth(u, v), 0.0F);
          EXPECT_EQ(rendering.class_id(u, v), ClassId::kUnknown);
          EXPECT_EQ(rendering.instance(u, v), 0);
          EXPECT_GT(rendering.color(u, v).b, 100) << "the sky is bright";
          continue;
        }
        ++hits;
        EXPECT_NEAR(rendering.depth(u, v), hit.depth, 2e-5) << u << ' ' << v;
        EXPECT_NEAR(rendering.cos_incidence(u, v), hit.cosine, 1e-4);
        EXPECT_EQ(rendering.class_id(u, v), hit.object->class_id);
        EXPECT_EQ(rendering.instance(u, v), hit.object->instance);
      }
    }
  }
  EXPECT_GT(hits, 500);
  EXPECT_GT(misses, 20);
}

TEST(Renderer, DepthIsPlanarAndPixelCentresAreAtIntegers) {
  const Scene scene = box_room();
  const Renderer renderer(scene);
  // Straight at the wall y = 3 from y = 1: the same depth in every pixel that sees the wall.
  const Rendering rendering = renderer.render(small_camera(), looking({0.5, 1, 1.9}, {0.5, 3, 1.9}));
  EXPECT_NEAR(rendering.depth(159, 59), 2, 1e-5);
  EXPECT_NEAR(rendering.depth(79, 59), 2, 1e-5);
  // The edge to the wall x = 0 lies 0.5 m to the left: at u = 79.5 - 144.5 * 0.5 / 2 = 43.375.
  EXPECT_NEAR(rendering.depth(44, 59), 2, 1e-5);
  EXPECT_LT(rendering.depth(43, 59), 1.999);
}

TEST(Renderer, GivesTheSamePictureAtAnyThreadCount) {
  const Scene scene = box_room();
  const auto picture = [&](int threads) {
    set_thread_count(threads);
    const Renderer renderer(scene);
    Rendering rendering = renderer.render(small_camera(), across_the_room());
    set_thread_count(0);
    return rendering;
  };
  const Rendering one = picture(1);
  const Rendering four = picture(4);
  EXPECT_EQ(one.color, four.color);
  EXPECT_EQ(one.depth, four.depth);
  EXPECT_EQ(one.cos_incidence, four.cos_incidence);
}

// Part of a barrel that lies along y, of facets that are narrower than the lattice of large triangles.
SceneModel barrel() {
  constexpr int kFacets = 12;
  SceneModel model;
  model.name = "barrel";
  for (int i = 0; i < kFacets; ++i) {
    const auto at = [](int k, float y) {
      const float angle = static_cast<float>(M_PI) * static_cast<float>(k) / kFacets;
      return Vec3f(0.3F * std::cos(angle), y, 0.3F * std::sin(angle));
    };
    test::add_quad({at(i, 0), at(i, 0.08F), at(i + 1, 0.08F), at(i + 1, 0)}, 0, model);
  }
  return model;
}

TEST(Renderer, LightDoesNotDependOnWhatWasSeenBefore) {
  Scene scene = box_room();
  test::add_object(barrel(), test::kCrateClass, 3, scene);
  scene.objects.back().world_from_object.translation() = Vec3d(1.2, 1.3, 0.74);
  const Renderer fresh(scene);
  const Renderer used(scene);
  for (int i = 0; i < 5; ++i) used.render(small_camera(), looking({2.4 + 0.3 * i, 0.4, 1.5}, {1.2, 1.4, 0.8}));
  const Pose pose = looking({0.3, 0.8, 1.3}, {1.2, 1.3, 0.9});
  EXPECT_TRUE(fresh.render(small_camera(), pose).color == used.render(small_camera(), pose).color);
}

TEST(Renderer, FindsTheNearestSurfaceAsALoopOverAllTrianglesDoes) {
  const Scene scene = box_room();
  const Surfaces surfaces = flatten(scene);
  const Renderer renderer(scene);
  Random random(7);
  for (int i = 0; i < 20; ++i) {
    const Vec3d p(random.uniform(-0.2, 4.2), random.uniform(-0.2, 3.2), random.uniform(-0.2, 2.7));
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t t = 0; t < surfaces.triangles.size(); ++t) best = std::min(best, naive_distance(surfaces, t, p));
    const auto found = renderer.nearest(p, 10);
    ASSERT_TRUE(found.has_value());
    EXPECT_NEAR(found->distance_m, best, 1e-6);
    EXPECT_FALSE(renderer.nearest(p, best * 0.99).has_value());
  }
}

TEST(Renderer, NamesTheNearestObject) {
  const Scene scene = box_room();
  const Renderer renderer(scene);
  const auto point = renderer.nearest({1.2, 1.5, 0.75}, 0.1);
  ASSERT_TRUE(point.has_value());
  EXPECT_EQ(point->class_id, test::kTableClass);
  EXPECT_EQ(point->instance, 1);
  EXPECT_NEAR(point->distance_m, 0.01, 1e-6);
}

double brightness(const Rgb& color) { return (color.r + color.g + color.b) / 3.0; }

// The brightness of the floor near (x, y), seen from straight above: the mean over a few pixels of the pattern.
double floor_brightness(const Renderer& renderer, double x, double y) {
  const Rendering rendering = renderer.render({9, 9, 40, 40, 4, 4}, looking({x, y - 0.001, 0.6}, {x, y, 0}));
  double sum = 0;
  for (const Rgb& color : rendering.color.pixels()) sum += brightness(color);
  return sum / static_cast<double>(rendering.color.size());
}

TEST(Renderer, SunFallsThroughTheWindowAndTheTableThrowsAShadow) {
  Scene scene = box_room();
  scene.textures[0] = test::checkers({120, 120, 120}, {120, 120, 120});
  const Renderer renderer(scene);
  // The sun stands in the direction (0.8, 0.1, 0.45): a floor point x is lit through the hole where
  // (4 - x) * 0.45 / 0.8 lies within its 0.9 .. 2.1 m, so between x = 0.27 and 2.4; y = 1.2 is out of the table's way.
  const double in_the_sun = floor_brightness(renderer, 2.0, 1.0);
  const double beside = floor_brightness(renderer, 3.2, 1.0);
  EXPECT_GT(in_the_sun, beside + 20);
  // The table's top, 0.7 m high, throws its shadow 0.7 * 0.8 / 0.45 = 1.24 m towards -x: up to x = 0.56.
  const double in_the_shadow = floor_brightness(renderer, 0.42, 1.35);
  EXPECT_LT(in_the_shadow, in_the_sun - 20);
}

TEST(Renderer, SunPassesWindowPanesButNotCurtains) {
  Scene scene = box_room();
  SceneModel pane;
  pane.name = "pane";
  test::add_quad({Vec3f(4, 2.2F, 0.9F), Vec3f(4, 0.8F, 0.9F), Vec3f(4, 0.8F, 2.1F), Vec3f(4, 2.2F, 2.1F)}, 0, pane);
  test::add_object(pane, test::kWindowClass, 3, scene);
  const double through_glass = floor_brightness(Renderer(scene), 2.0, 1.0);
  scene.objects.back().class_id = test::kCurtainClass;
  const double behind_cloth = floor_brightness(Renderer(scene), 2.0, 1.0);
  EXPECT_NEAR(through_glass, floor_brightness(Renderer(box_room()), 2.0, 1.0), 2);
  EXPECT_LT(behind_cloth, through_glass - 20);
}

TEST(Renderer, CornersAreDarkerThanOpenWalls) {
  Scene scene = box_room();
  scene.lamps.clear();
  scene.towards_sun = Vec3f(0, 0, -1);
  const Renderer renderer(scene);
  const Rendering rendering = renderer.render(small_camera(), looking({2, 2.0, 1.4}, {0, 0, 1.4}));
  EXPECT_LT(brightness(rendering.color(80, 59)), brightness(rendering.color(20, 59)) - 10);
}

TEST(Renderer, SmoothsCurvedSurfacesAndKeepsEdges) {
  Scene scene;
  scene.materials = {{{200, 200, 200}, -1}};
  test::add_object(barrel(), test::kCrateClass, 1, scene);
  scene.towards_sun = Vec3f(0.6F, 0, 1);
  const Renderer renderer(scene);
  const Rendering rendering = renderer.render({200, 9, 300, 300, 99.5, 4}, looking({0, 0.039, 1}, {0, 0.04, 0}));
  int largest_step = 0;
  int brightest = 0;
  int darkest = 255;
  for (int u = 15; u < 184; ++u) {
    const int here = rendering.color(u, 4).g;
    largest_step = std::max(largest_step, std::abs(here - rendering.color(u + 1, 4).g));
    brightest = std::max(brightest, here);
    darkest = std::min(darkest, here);
  }
  EXPECT_GT(brightest - darkest, 40);
  EXPECT_LE(largest_step, 7);  // bare facets of 15 degrees make larger steps
}

TEST(Renderer, TakesAnEmptySceneAndOneWithFlatTriangles) {
  Scene scene;
  EXPECT_EQ(Renderer(scene).render(small_camera(), across_the_room()).depth(5, 5), 0.0F);
  scene = box_room();
  scene.models[3].triangles.push_back({0, 0, 0});
  scene.models[3].triangles.push_back({0, 1, 1});
  scene.models[3].material_of.insert(scene.models[3].material_of.end(), 2, 2);
  const Renderer renderer(scene);
  EXPECT_GT(renderer.render(small_camera(), across_the_room()).depth(80, 60), 0.5F);
  EXPECT_TRUE(renderer.nearest({1.2, 1.5, 0.75}, 0.1).has_value());
}

TEST(Renderer, RefusesScenesWhoseIndicesPointNowhere) {
  const auto message = [](auto break_scene) {
    Scene scene = box_room();
    break_scene(scene);
    return test::error_of([&] { const Renderer renderer(scene); });
  };
  EXPECT_THAT(message([](Scene& scene) { scene.models[3].triangles[0][1] = 1000000; }), HasSubstr("'table'"));
  EXPECT_THAT(message([](Scene& scene) { scene.models[3].material_of[0] = 99; }), HasSubstr("material"));
  EXPECT_THAT(message([](Scene& scene) { scene.models[3].uvs.pop_back(); }), HasSubstr("texture coordinates"));
  EXPECT_THAT(message([](Scene& scene) { scene.models[3].positions[5].y() = NAN; }), HasSubstr("corner at infinity"));
  EXPECT_THAT(message([](Scene& scene) { scene.models[3].uvs[5].x() = INFINITY; }), HasSubstr("texture coordinate"));
  EXPECT_THAT(message([](Scene& scene) { scene.objects[3].model = 77; }), HasSubstr("'table' has no model"));
  EXPECT_THAT(message([](Scene& scene) { scene.materials[0].texture = 5; }), HasSubstr("texture 5"));
}

}  // namespace
}  // namespace panoptic
