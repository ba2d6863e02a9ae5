// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/benchmark/substitutes.h"

#include <gtest/gtest.h>

#include <set>

#include "panoptic/map.h"
#include "panoptic/mapper.h"
#include "panoptic/sim/prediction_noise.h"

namespace panoptic {
namespace {

// One room, filmed once for all tests here.
class SubstituteMapperTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const Simulation simulation(parse_simulation("sim:3,rooms=1,frames=12"));
    labels = load_label_set("scannet20");
    for (std::size_t i = 0; i < simulation.size(); ++i) {
      frames.push_back(simulation.simulate(i));
      masks.push_back(predict_with_noise(prediction_noise_preset("maskrcnn"), 3, frames.back(), labels));
    }
  }
  static void TearDownTestSuite() {
    frames.clear();
    masks.clear();
  }

  static void map(SubstituteMapper& mapper) {
    for (std::size_t i = 0; i < frames.size(); ++i) {
      ASSERT_EQ(mapper.add(frames[i].frame, masks[i], frames[i].rendering.instance), Outcome{});
    }
  }

  static Options without_regularizer() {
    Options options;
    options.regularizer.enabled = false;
    options.objects.enabled = false;
    return options;
  }

  inline static std::vector<SimulatedFrame> frames;
  inline static std::vector<Segmentation> masks;
  inline static LabelSet labels;
};

TEST_F(SubstituteMapperTest, WithoutSubstitutesTheMapIsTheMappers) {
  Mapper mapper(without_regularizer(), labels);
  for (std::size_t i = 0; i < frames.size(); ++i) ASSERT_EQ(mapper.add(frames[i].frame, masks[i]), Outcome{});
  SubstituteMapper substitute(without_regularizer(), labels, {});
  map(substitute);
  ASSERT_GT(mapper.map().objects.count(), 3U);
  EXPECT_EQ(mapper.map().voxels.hash(), substitute.map().voxels.hash());
  EXPECT_EQ(mapper.map().objects.count(), substitute.map().objects.count());
}

TEST_F(SubstituteMapperTest, TrueTrackingMakesAtMostOneObjectPerThing) {
  SubstituteMapper substitute(without_regularizer(), labels, {.tracking = true});
  map(substitute);
  std::set<std::uint16_t> things;
  for (const SimulatedFrame& frame : frames) {
    for (const std::uint16_t instance : frame.rendering.instance.pixels()) things.insert(instance);
  }
  things.erase(0);
  EXPECT_GT(substitute.map().objects.count(), 3U);
  EXPECT_LE(substitute.map().objects.count(), things.size());
}

TEST_F(SubstituteMapperTest, CountingAllVotesChangesLabelsButNotTheSurface) {
  SubstituteMapper one_slot(without_regularizer(), labels, {});
  SubstituteMapper all_votes(without_regularizer(), labels, {.storage = true});
  map(one_slot);
  map(all_votes);
  EXPECT_EQ(one_slot.map().voxels.hash(), all_votes.map().voxels.hash());
  const Mesh slots = one_slot.mesh();
  const Mesh votes = all_votes.mesh();
  ASSERT_EQ(slots.vertices.size(), votes.vertices.size());
  std::size_t different = 0;
  for (std::size_t i = 0; i < slots.vertices.size(); ++i) {
    different += slots.vertices[i].panoptic_id != votes.vertices[i].panoptic_id ? 1 : 0;
  }
  EXPECT_GT(different, 0U);
  EXPECT_LT(different, slots.vertices.size() / 4);
}

}  // namespace
}  // namespace panoptic
