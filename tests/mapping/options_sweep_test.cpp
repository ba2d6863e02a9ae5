// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Every number among the options at both ends of its range, and those that meet in one formula together: each gives a sound map,
// or an Error of one line.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <utility>

#include "panoptic/base/config.h"
#include "panoptic/error.h"
#include "panoptic/frame_statistics.h"
#include "panoptic/map.h"
#include "panoptic/mapper.h"
#include "panoptic/mapping/option_fields.h"
#include "tests/block_planes.h"
#include "tests/fresh_seed.h"
#include "tests/fusion/scenes.h"
#include "tests/sanitized.h"

namespace panoptic {
namespace {

using Setting = std::pair<std::string, double>;
using Settings = std::vector<Setting>;

constexpr int kFrames = 4;

// Two balls on a floor and a wall far away, of few pixels: a voxel of a millimetre takes as much memory as each of them allows.
Frame rendered(int i) {
  const test::Surface scene =
      test::nearest_of({test::sphere({0, 0, 0}, 0.5), test::sphere({0.9, 0.2, 0.3}, 0.3), test::plane(Vec3d::UnitY(), 0.5),
                        test::plane(Vec3d(1, -1, 0).normalized(), -600)});
  const double angle = 0.3 * (i % 2);
  return test::render(scene, test::small_camera(16, 12),
                      test::look_at({2 * std::cos(angle), -0.9, 2 * std::sin(angle)}, {0, -0.2, 0}), i);
}

// Segments that change their numbers and their outlines from frame to frame.
Segmentation segmentation_of(const Frame& frame) {
  const ClassId chair{3};
  Segmentation s{Image<std::uint16_t>(frame.color.width(), frame.color.height()),
                 {{chair, 0.9F, {{chair, 1}}}, {ClassId{2}, 1, {}}, {chair, 0.8F, {}}, {chair, 0.4F, {}}}};
  for (int v = 0; v < frame.depth.height(); ++v) {
    for (int u = 0; u < frame.depth.width(); ++u) {
      const Vec3d p = frame.world_from_camera * back_project(frame.depth_camera, u, v, frame.depth(u, v));
      const bool other_half = frame.index % 2 == 1 && p.y() < -0.2;
      s.segment_at(u, v) = static_cast<std::uint16_t>(p.y() > 0.499 ? 2 : p.x() > 0.5 ? 3 : other_half ? 4 : 1);
    }
  }
  return s;
}

bool is_finite(const VoxelMap& map) {
  for (Slot slot = 0; slot < map.block_count(); ++slot) {
    const BlockPlanes block = test::planes_of(map.block(slot));
    for (const auto* plane : {&block.distance, &block.weight, &block.label_weight}) {
      if (!std::all_of(plane->begin(), plane->end(), [](float value) { return std::isfinite(value); })) return false;
    }
  }
  return true;
}

void expect_sound(Mapper& mapper) {
  EXPECT_TRUE(is_finite(mapper.map().voxels));
  const Mesh mesh = mapper.mesh();
  EXPECT_TRUE(std::all_of(mesh.vertices.begin(), mesh.vertices.end(),
                          [](const MeshVertex& vertex) { return vertex.position.allFinite() && vertex.normal.allFinite(); }));
  EXPECT_EQ(mapper.frames().used() + mapper.frames().skipped(), static_cast<std::uint64_t>(kFrames));
}

// Nothing if the options give a map, else the reason.
std::optional<std::string> error_of(const Options& options) {
  try {
    Mapper mapper(options, test::test_labels());
    for (int i = 0; i < kFrames; ++i) {
      const Frame frame = rendered(i);
      static_cast<void>(mapper.add(frame, segmentation_of(frame)));
    }
    mapper.finish();
    expect_sound(mapper);
  } catch (const Error& e) {
    return e.what();
  }
  return std::nullopt;
}

// So that everything happens within a few frames.
Options base() {
  Options options;
  options.objects.every_frames = 2;
  options.objects.merge_share = 0;
  options.regularizer.every_frames = 3;
  return options;
}

Fields numbers(Options& options) {
  Fields all = fields(options);
  std::erase_if(all, [](const Field& f) {
    return !std::holds_alternative<int*>(f.value) && !std::holds_alternative<float*>(f.value) &&
           !std::holds_alternative<double*>(f.value);
  });
  return all;
}

void expect_map_or_error(const Settings& settings, const std::string& method = "projective") {
  Options options = base();
  std::string text = method;
  for (const auto& [key, value] : settings) {
    const std::string assignment = fmt::format("{}={}", key, value);
    text += " " + assignment;
    set_field(fields(options), assignment);
  }
  options.integrator.method = method;
  SCOPED_TRACE(text);
  const std::string error = error_of(options).value_or("");
  EXPECT_EQ(error.find('\n'), std::string::npos) << error;
}

std::vector<double> ends_of(const std::string& key) {
  Options options;
  for (const Field& field : numbers(options)) {
    if (field.key == key) return {field.allowed.min, field.allowed.max};
  }
  ADD_FAILURE() << key << " is no number among the options";
  return {};
}

// Both ends, or one of them by chance under a sanitizer, where a map takes twenty times as long.
class Ends {
 public:
  std::vector<double> operator()(const std::string& key) {
    const std::vector<double> ends = ends_of(key);
    return test::kSanitized && ends.size() == 2 ? std::vector{ends[random_() % 2]} : ends;
  }

 private:
  std::mt19937 random_{test::kSanitized ? test::fresh_seed() : 0};
};

TEST(OptionsSweep, EveryNumberAtBothEndsOfItsRangeGivesAMapOrAnError) {
  Options options;
  const Fields all = numbers(options);
  ASSERT_GT(all.size(), 30U);
  Ends ends;
  for (const Field& field : all) {
    ASSERT_TRUE(std::isfinite(field.allowed.min) && std::isfinite(field.allowed.max)) << field.key << " has no range";
    for (const double end : ends(field.key)) expect_map_or_error({{field.key, end}});
  }
}

// Which numbers meet in one formula.
const std::vector<std::pair<const char*, const char*>> kMeeting = {
    {"map.voxel_size_m", "objects.merge_distance_m"},               // reach of contacts
    {"map.voxel_size_m", "map.truncation_voxels"},                  // width of the band
    {"map.voxel_size_m", "depth.max_m"},                            // voxel coordinates
    {"map.voxel_size_m", "map.memory_limit_mb"},                    // blocks in memory
    {"map.voxel_size_m", "regularizer.theta_alpha_m"},              // reach of both kernels, halo
    {"map.voxel_size_m", "regularizer.band_voxels"},                // voxels that are regularized
    {"map.voxel_size_m", "objects.min_thing_m2"},                   // voxels of an area
    {"map.voxel_size_m", "objects.min_region_m2"},                  //
    {"map.voxel_size_m", "objects.carve_height_m"},                 // heights above planes
    {"map.voxel_size_m", "objects.floor_height_m"},                 //
    {"map.truncation_voxels", "regularizer.band_voxels"},           //
    {"map.truncation_voxels", "depth.max_m"},                       //
    {"depth.min_m", "depth.max_m"},                                 // readings that are left
    {"depth.min_m", "integrator.object_vote"},                      // weights, 1 / depth^2
    {"integrator.object_vote", "regularizer.highest_probability"},  // Eq. 19
    {"regularizer.w1", "regularizer.w2"},                           // Eq. 14
    {"regularizer.w1", "regularizer.theta_alpha_m"},                // sums of the kernels
    {"regularizer.w2", "regularizer.highest_probability"},          //
    {"regularizer.theta_alpha_m", "regularizer.theta_beta"},        // clusters
    {"regularizer.theta_alpha_m", "regularizer.max_blocks"},        // size of a tile
    {"objects.merge_distance_m", "objects.merge_share"},            //
    {"objects.merge_share", "objects.together_share"},              //
    {"objects.stray_share", "objects.size_margin"},                 //
    {"objects.every_frames", "objects.min_observations"},           //
    {"objects.min_thing_m2", "objects.min_region_m2"},              //
};

// Each end of both numbers, with one end of the other by chance: two of the four pairs of ends in each run of this test.
TEST(OptionsSweep, NumbersThatMeetInOneFormulaGiveAMapOrAnErrorAtAllTheirEnds) {
  Ends ends;
  std::mt19937 random(test::fresh_seed());
  for (const auto& [first, second] : test::third_under_a_sanitizer(kMeeting)) {
    const std::vector<double> a = ends(first);
    const std::vector<double> b = ends(second);
    const std::size_t shift = random() % 2;
    for (std::size_t i = 0; i < a.size(); ++i) expect_map_or_error({{first, a[i]}, {second, b[(i + shift) % b.size()]}});
  }
}

TEST(OptionsSweep, AlsoWhenRaysAreCast) {
  Ends ends;
  for (const char* other : {"map.truncation_voxels", "depth.min_m", "depth.max_m", "integrator.object_vote"}) {
    for (const double voxel_m : ends("map.voxel_size_m")) {
      for (const double end : ends(other)) expect_map_or_error({{"map.voxel_size_m", voxel_m}, {other, end}}, "raycast");
    }
  }
}

// Both ended in a segmentation fault.
TEST(OptionsSweep, SmallVoxelsAndFarMergesGiveAMap) {
  for (const Setting& setting : {Setting("map.voxel_size_m", 0.004), Setting("objects.merge_distance_m", 0.41)}) {
    Options options = base();
    set_field(fields(options), fmt::format("{}={}", setting.first, setting.second));
    EXPECT_EQ(error_of(options), std::nullopt) << setting.first;
  }
}

}  // namespace
}  // namespace panoptic
