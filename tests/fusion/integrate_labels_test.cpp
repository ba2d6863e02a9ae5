// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Labels that come later than the frame that they are of.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

#include "panoptic/fusion/integrator.h"
#include "tests/block_planes.h"
#include "tests/fusion/naive_grazing.h"
#include "tests/fusion/scenes.h"

namespace panoptic {
namespace {

constexpr float kVoxel_m = 0.024F;
constexpr std::uint16_t kFirstObject = 4;

std::vector<Frame> orbit(int frames) {
  const test::Surface scene = test::nearest_of({test::sphere({0, 0, 0}, 0.6), test::plane(Vec3d::UnitY(), 0.6)});
  std::vector<Frame> result;
  for (int i = 0; i < frames; ++i) {
    const double angle = 0.2 * i;
    result.push_back(
        test::render(scene, test::small_camera(), test::look_at({2 * std::cos(angle), -0.9, 2 * std::sin(angle)}, {0, 0, 0}), i));
  }
  return result;
}

// Patches of many labels, of pixels without a vote, and of pixels without a label, other ones in every frame.
std::vector<LabelSlot> patches(const RegisteredFrame& frame, std::int64_t index) {
  std::vector<LabelSlot> labels(frame.segment.size(), LabelSlot::kNoVote);
  for (std::size_t i = 0; i < frame.pixel_count(); ++i) {
    const auto u = static_cast<std::int64_t>(i) % frame.width;
    const auto v = static_cast<std::int64_t>(i) / frame.width;
    const std::int64_t patch = (u + 7 * index) / 23 + 3 * (v / 17);
    if (patch % 5 != 0) labels[i] = static_cast<LabelSlot>(patch % 7);
  }
  return labels;
}

struct Fusion {
  explicit Fusion(const std::string& method, float max_weight = 0)
      : map({kVoxel_m, 4, max_weight}), integrator({method, 4}, map, kFirstObject) {}

  void add(const Frame& frame) {
    const RegisteredFrame& registered = registration.apply(frame, test::halves(frame.color_camera));
    integrator.integrate(frame, registered, patches(registered, frame.index), map);
  }
  void add_geometry(const Frame& frame) {
    const RegisteredFrame& registered = registration.apply(frame, {});
    integrator.integrate(frame, registered, std::vector<LabelSlot>(registered.segment.size(), LabelSlot::kNoVote), map);
  }
  void add_labels(const Frame& frame) {
    const RegisteredFrame& registered = registration.apply(frame, test::halves(frame.color_camera));
    integrator.integrate_labels(frame, registered, patches(registered, frame.index), map);
  }

  VoxelMap map;
  Registration registration{{}};
  Integrator integrator;
};

class IntegrateLabels : public testing::TestWithParam<const char*> {};

TEST_P(IntegrateLabels, AfterTheGeometryGiveTheMapOfBothAtOnceBitForBit) {
  for (const float max_weight : {0.0F, 1.0F}) {  // the latter is reached after a few frames
    Fusion at_once(GetParam(), max_weight);
    Fusion one_by_one(GetParam(), max_weight);
    Fusion long_after(GetParam(), max_weight);
    const std::vector<Frame> frames = orbit(6);
    for (const Frame& frame : frames) {
      at_once.add(frame);
      one_by_one.add_geometry(frame);
      one_by_one.add_labels(frame);
      long_after.add_geometry(frame);
    }
    for (const Frame& frame : frames) long_after.add_labels(frame);
    EXPECT_EQ(one_by_one.map.hash(), at_once.map.hash());
    EXPECT_EQ(long_after.map.hash(), at_once.map.hash());
  }
}

// With votes of weight 1 from every pixel, Eq. 18 may as well divide by W^D, as the paper does.
TEST_P(IntegrateLabels, OfEveryPixelSumUpToTheWeightOfTheDistanceBitForBit) {
  VoxelMap map({kVoxel_m, 4});
  Integrator integrator({GetParam(), 1}, map, kFirstObject);
  Registration registration({});
  for (const Frame& frame : orbit(5)) {
    const RegisteredFrame& registered = registration.apply(frame, {});
    std::vector<LabelSlot> labels = patches(registered, frame.index);
    for (LabelSlot& label : labels) label = label == LabelSlot::kNoVote ? LabelSlot{kFirstObject + 1} : label;
    integrator.integrate(frame, registered, labels, map);
  }
  std::size_t contested = 0;
  for (Slot slot = 0; slot < map.block_count(); ++slot) {
    const BlockPlanes block = test::planes_of(map.block(slot));
    ASSERT_EQ(block.vote_sum, block.weight);
    for (std::size_t v = 0; v < kBlockVoxels; ++v) {
      ASSERT_LE(block.label_weight[v], block.vote_sum[v]);
      contested += block.label_weight[v] < 0.9F * block.vote_sum[v] ? 1 : 0;
    }
  }
  EXPECT_GT(contested, 1000U);
}

TEST_P(IntegrateLabels, CountForTheSumWhateverTheyAreForAndNoWeightExceedsItsLimit) {
  Fusion unlimited(GetParam());
  Fusion limited(GetParam(), 0.5F);
  for (const Frame& frame : orbit(6)) {
    unlimited.add(frame);
    limited.add(frame);
  }
  std::size_t reached = 0;
  ASSERT_EQ(unlimited.map.block_count(), limited.map.block_count());
  for (Slot slot = 0; slot < limited.map.block_count(); ++slot) {
    const BlockPlanes block = test::planes_of(limited.map.block(slot));
    const BlockPlanes all = test::planes_of(unlimited.map.block(slot));
    for (std::size_t v = 0; v < kBlockVoxels; ++v) {
      ASSERT_EQ(block.weight[v], std::min(0.5F, all.weight[v]));
      ASSERT_EQ(block.vote_sum[v], std::min(0.5F, all.vote_sum[v]));
      ASSERT_LE(block.label_weight[v], block.vote_sum[v]);
      ASSERT_LE(all.label_weight[v], all.vote_sum[v]);
      ASSERT_TRUE(std::isfinite(block.distance[v]));
      reached += all.vote_sum[v] > 0.5F ? 1 : 0;
    }
  }
  EXPECT_GT(reached, 1000U);
}

TEST_P(IntegrateLabels, TouchNeitherDistanceNorColourNorAnyWeightButTheirOwn) {
  Fusion fusion(GetParam());
  const Frame frame = orbit(1)[0];
  fusion.add_geometry(frame);
  std::vector<BlockPlanes> before;
  for (Slot slot = 0; slot < fusion.map.block_count(); ++slot) before.push_back(test::planes_of(fusion.map.block(slot)));
  const std::uint64_t epoch = fusion.map.epoch();
  fusion.add_labels(frame);
  bool any_label = false;
  ASSERT_EQ(fusion.map.block_count(), before.size());
  for (Slot slot = 0; slot < before.size(); ++slot) {
    const BlockPlanes now = test::planes_of(fusion.map.block(slot));
    EXPECT_EQ(now.distance, before[slot].distance);
    EXPECT_EQ(now.weight, before[slot].weight);
    EXPECT_EQ(now.red, before[slot].red);
    EXPECT_EQ(now.green, before[slot].green);
    EXPECT_EQ(now.blue, before[slot].blue);
    if (now.label_weight == before[slot].label_weight) continue;
    any_label = true;
    EXPECT_GT(fusion.map.changed_at(slot), epoch) << "readers of the map must see the change";
  }
  EXPECT_TRUE(any_label);
}

TEST_P(IntegrateLabels, DoNotMakeBlocks) {
  Fusion fusion(GetParam());
  fusion.add_labels(orbit(1)[0]);
  EXPECT_EQ(fusion.map.block_count(), 0U);
}

INSTANTIATE_TEST_SUITE_P(BothMethods, IntegrateLabels, testing::Values("projective", "raycast"),
                         [](const auto& tested) { return std::string(tested.param); });

struct NaiveLabel {
  std::uint16_t label = 0;
  double weight = 0;
  bool near_tie = false;  // where rounding may decide

  // Eq. 9-11, with the votes of objects counted four times.
  void observe(std::uint16_t observed, double quadric) {
    const double w = quadric * (observed >= kFirstObject ? 4 : 1);
    if (observed == label) {
      weight += w;
      return;
    }
    near_tie |= std::abs(w - weight) < 1e-4 * (w + weight);
    if (w > weight) label = observed;
    weight = std::abs(w - weight);
  }
};

// The labels of one frame for every voxel of a block, by projecting its centre.
void observe_naively(const Frame& frame, const RegisteredFrame& registered, const std::vector<LabelSlot>& labels, BlockIndex b,
                     std::vector<NaiveLabel>& voxels) {
  const KernelFrame pixels = test::depths_of(frame, registered);
  constexpr double kBand_m = 4 * double{kVoxel_m};
  const Pose camera_from_world = frame.world_from_camera.inverse();
  for (int i = 0; i < kBlockVoxels; ++i) {
    const Vec3d place(16 * b.x + i % 16 + 0.5, 16 * b.y + i / 16 % 16 + 0.5, 16 * b.z + i / 256 + 0.5);
    const Vec3d p = camera_from_world * (place * double{kVoxel_m});
    const double u = std::floor(frame.depth_camera.fx * p.x() / p.z() + frame.depth_camera.cx + 0.5);
    const double v = std::floor(frame.depth_camera.fy * p.y() / p.z() + frame.depth_camera.cy + 0.5);
    if (p.z() <= 0 || u < 0 || v < 0 || u >= registered.width || v >= registered.height) continue;
    const auto pixel = static_cast<std::size_t>(v * registered.width + u);
    const double z = registered.depth[pixel];
    if (z <= 0 || labels[pixel] == LabelSlot::kNoVote) continue;
    const double scale = test::naive_scale(pixels, {static_cast<float>(kBand_m), kVoxel_m}, double{kVoxel_m}, static_cast<int>(u),
                                           static_cast<int>(v));
    const double d = (z - p.z()) * p.norm() / p.z() * scale;
    if (std::abs(d) >= kBand_m) continue;
    const double drop = d < -double{kVoxel_m} ? (kBand_m + d) / (kBand_m - double{kVoxel_m}) : 1;
    voxels[static_cast<std::size_t>(i)].observe(number(labels[pixel]), drop / (z * z));
  }
}

TEST(LabelsOfAFrame, EqualTheNaiveReferenceVoxelByVoxel) {
  Fusion fusion("projective");
  const std::vector<Frame> frames = orbit(5);
  for (const Frame& frame : frames) fusion.add_geometry(frame);
  std::map<Slot, std::vector<NaiveLabel>> naive;
  for (Slot slot = 0; slot < fusion.map.block_count(); ++slot) naive[slot].resize(kBlockVoxels);
  for (const std::size_t i : {0U, 2U, 4U}) {
    const RegisteredFrame registered = fusion.registration.apply(frames[i], {});
    const std::vector<LabelSlot> labels = patches(registered, frames[i].index);
    fusion.add_labels(frames[i]);
    for (auto& [slot, voxels] : naive) {  // which blocks a frame concerns is for the tests of integration
      if (fusion.map.changed_at(slot) != fusion.map.epoch()) continue;
      observe_naively(frames[i], registered, labels, fusion.map.index_of(slot), voxels);
    }
  }
  std::size_t labelled = 0;
  std::size_t different = 0;
  for (const auto& [slot, voxels] : naive) {
    const BlockPlanes block = test::planes_of(fusion.map.block(slot));
    for (std::size_t v = 0; v < voxels.size(); ++v) {
      labelled += voxels[v].weight > 0 ? 1 : 0;
      const bool same = block.label[v] == voxels[v].label &&
                        std::abs(double{block.label_weight[v]} - voxels[v].weight) <= 1e-3 * (1 + voxels[v].weight);
      different += same || voxels[v].near_tie ? 0 : 1;
    }
  }
  EXPECT_GT(labelled, 20000U);
  EXPECT_LT(different, labelled / 1000) << "pixels chosen by rounding a border in float or in double";
}

}  // namespace
}  // namespace panoptic
