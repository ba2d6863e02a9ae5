// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/ground_truth.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

namespace panoptic::test {
namespace {

TEST(GroundTruth, LiesOnTheSceneAndKnowsWhatEverythingIs) {
  const Simulation simulation({.seed = 3, .rooms = 1, .frames = 10, .noise = "harsh"});
  const ScanTruth truth = ground_truth(simulation);
  ASSERT_GT(truth.positions.size(), 10000U);
  ASSERT_EQ(truth.class_id.size(), truth.positions.size());
  ASSERT_EQ(truth.instance.size(), truth.positions.size());
  ASSERT_EQ(truth.colors.size(), truth.positions.size());
  EXPECT_EQ(truth.scene, "scene0003_00");

  std::map<std::uint16_t, ClassId> class_of;  // as the scene has it
  for (const SceneObject& object : simulation.home().scene.objects) class_of[object.instance] = object.class_id;
  std::set<std::uint16_t> seen;
  std::size_t stuff = 0;
  std::size_t near = 0;
  const LabelSet labels = load_label_set("scannet20");
  for (std::size_t i = 0; i < truth.positions.size(); ++i) {
    if (truth.instance[i] != 0) {
      ASSERT_EQ(truth.class_id[i], class_of.at(truth.instance[i]));
      seen.insert(truth.instance[i]);
    }
    stuff += labels.is_stuff(truth.class_id[i]) ? 1 : 0;
    near += i % 97 == 0 && simulation.renderer().nearest(truth.positions[i].cast<double>(), 0.01) ? 1 : 0;
  }
  EXPECT_GT(seen.size(), 3U);
  EXPECT_EQ(truth.names.size(), seen.size());
  EXPECT_GT(stuff, truth.positions.size() / 10);
  EXPECT_GT(near, truth.positions.size() / 97 * 9 / 10);  // true poses and depth: within half a voxel of the surface
}

}  // namespace
}  // namespace panoptic::test
