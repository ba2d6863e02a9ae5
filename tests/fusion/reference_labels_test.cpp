// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/reference_labels.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/block_planes.h"
#include "tests/fusion/scenes.h"

namespace panoptic {
namespace {

// Eq. 2 as it stands: the label at T K^-1 D(u) [u, 1].
LabelSlot naive_reference(const VoxelMap& map, const Frame& frame, int u, int v) {
  const double z = frame.depth(u, v);
  if (z <= 0) return LabelSlot::kUnknown;
  const Vec3d p = frame.world_from_camera * back_project(frame.depth_camera, u, v, z) / map.voxel_size_m();
  const int x = static_cast<int>(std::floor(p.x()));
  const int y = static_cast<int>(std::floor(p.y()));
  const int k = static_cast<int>(std::floor(p.z()));
  const VoxelBlock* block = map.find({x >> 4, y >> 4, k >> 4});
  if (block == nullptr) return LabelSlot::kUnknown;
  return static_cast<LabelSlot>(block->label(voxel_offset(x & 15, y & 15, k & 15)));
}

TEST(ReferenceLabels, AgreeWithTheNaiveReferenceOnAMapOfRandomLabels) {
  const Pose pose = test::look_at({0.3, -0.2, -1.9}, {0.1, 0.4, 1});
  Frame frame = test::render(test::sphere({0, 0, 0}, 0.8), test::small_camera(), pose);
  VoxelMap map({});
  std::uint32_t random = 1;
  for (int x = -3; x < 3; ++x) {
    for (int y = -3; y < 3; ++y) {
      for (int z = -3; z < 1; ++z) {
        test::BlockEdit edit(map.block(map.allocate({x, y, z})));
        for (std::uint16_t& label : edit->label) {
          random = random * 1664525U + 1013904223U;
          label = static_cast<std::uint16_t>(random >> 16);
        }
      }
    }
  }
  Registration registration({});
  const RegisteredFrame& registered = registration.apply(frame, {});
  std::vector<LabelSlot> labels;
  reference_labels(map, frame, registered, labels);
  int different = 0;
  int labelled = 0;
  for (int v = 0; v < frame.depth.height(); ++v) {
    for (int u = 0; u < frame.depth.width(); ++u) {
      const LabelSlot expected = naive_reference(map, frame, u, v);
      const LabelSlot actual = labels[static_cast<std::size_t>(v * frame.depth.width() + u)];
      labelled += expected != LabelSlot::kUnknown ? 1 : 0;
      different += expected != actual ? 1 : 0;
    }
  }
  EXPECT_GT(labelled, 2000);
  EXPECT_LE(different, labelled / 1000 + 1);  // points on a voxel border may round to either side
}

TEST(ReferenceLabels, AreUnknownWhereTheMapIsEmpty) {
  const Frame frame = test::render(test::plane(Vec3d::UnitZ(), 2), test::small_camera(), Pose::Identity());
  Registration registration({});
  std::vector<LabelSlot> labels;
  reference_labels(VoxelMap({}), frame, registration.apply(frame, {}), labels);
  ASSERT_EQ(labels.size(), frame.depth.size());
  for (const LabelSlot id : labels) ASSERT_EQ(id, LabelSlot::kUnknown);
}

}  // namespace
}  // namespace panoptic
