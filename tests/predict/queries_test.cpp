// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "panoptic/predict/decoders.h"
#include "tests/expect_error.h"

namespace panoptic {
namespace {

using test::error_of;
using testing::HasSubstr;

constexpr auto kWall = static_cast<ClassId>(1);
constexpr auto kChair = static_cast<ClassId>(2);
const std::vector<ClassId> kClassOf = {kWall, kChair, ClassId::kUnknown};
const Placement kPlacement{16, 12, 16, 12, 1, 1};

LabelSet room() { return {"room", {{kWall, "wall", false, {}}, {kChair, "chair", true, {}}}}; }

Model query_model() {
  Model model;
  model.path = "mask2former.toml";
  model.classes = {"wall", "chair", "lamp"};
  model.input.width = 16;
  model.input.height = 12;
  return model;
}

// Three queries on a grid of 4 x 3: a wall on the left, a chair on the right (.7, .2 a lamp, .1 nothing), and no object.
std::vector<Tensor> outputs() {
  Tensor logits{{1, 3, 4}, {}, "class_queries_logits"};
  for (const double p : {0.9, 0.04, 0.03, 0.03, 1e-6, 0.7, 0.2, 0.1, 0.02, 0.02, 0.01, 0.95}) {
    logits.values.push_back(static_cast<float>(std::log(p)));
  }
  Tensor masks{{1, 3, 3, 4}, {}, "masks_queries_logits"};
  for (int q = 0; q < 3; ++q) {
    for (int i = 0; i < 12; ++i) masks.values.push_back((q == 0) == (i % 4 < 2) ? 8.0F : -8.0F);
  }
  return {logits, masks};
}

TEST(Queries, StandForClassesAndForInstances) {
  const Model model = query_model();
  const LabelSet labels = room();
  const Reading reading = recognise(outputs(), model, "instance");
  EXPECT_EQ(reading.task, "panoptic");
  const Findings found = decode(outputs(), reading, {model, kClassOf, kPlacement, false, &labels});
  ASSERT_TRUE(found.scores.has_value());
  const Image<ClassId> classes = most_likely(*found.scores, 16, 12);
  EXPECT_EQ(classes(2, 6), kWall);
  EXPECT_EQ(classes(13, 6), kChair);
  ASSERT_EQ(found.instances.size(), 1U);  // a wall has no instances, and the third query says that there is nothing
  const Instance& chair = found.instances[0];
  EXPECT_EQ(chair.segment.class_id, kChair);
  EXPECT_NEAR(chair.segment.score, 0.9, 1e-4);  // 1 - p(no object)
  ASSERT_EQ(chair.segment.class_probabilities.size(), 1U);
  EXPECT_NEAR(chair.segment.class_probabilities[0].probability, 1, 1e-6);
  int pixels = 0;
  for (int v = 0; v < chair.mask.height(); ++v) {
    for (int u = 0; u < chair.mask.width(); ++u) {
      if (chair.mask(u, v) == 0) continue;
      EXPECT_GE(chair.x0 + u, 6);
      ++pixels;
    }
  }
  EXPECT_NEAR(pixels, 96, 12);
}

TEST(Queries, GiveAPixelToOneOfThem) {
  const Model model = query_model();
  const LabelSet labels = room();
  std::vector<Tensor> twice = outputs();
  for (int i = 0; i < 4; ++i)
    twice[0].values[8U + static_cast<std::size_t>(i)] = twice[0].values[4U + static_cast<std::size_t>(i)];
  const Findings found = decode(twice, recognise(twice, model, "instance"), {model, kClassOf, kPlacement, false, &labels});
  EXPECT_EQ(found.instances.size(), 1U);  // the second chair has the same pixels
}

TEST(Queries, RefuseMasksWithoutCellsAndOutputsOfOtherRoles) {
  Model model = query_model();
  std::vector<Tensor> flat = outputs();
  flat[1] = Tensor{{1, 3, 0, 4}, {}, "masks_queries_logits"};
  EXPECT_THAT(recognise_queries(flat, model).why_not, HasSubstr("no output has 3 masks"));
  model.outputs = {{"classes", "masks_queries_logits"}};
  EXPECT_THAT(error_of([&] { recognise(outputs(), model, "instance"); }), HasSubstr("does not have the shape"));
  model.outputs = {{"masks", "class_queries_logits"}};
  EXPECT_THAT(error_of([&] { recognise(outputs(), model, "instance"); }), HasSubstr("does not have the shape"));
}

TEST(Queries, NeedNoObjectBesideTheClasses) {
  Model model = query_model();
  model.classes = {"wall", "chair", "lamp", "sofa", "bed"};
  EXPECT_THAT(error_of([&] { recognise(outputs(), model, "instance"); }), HasSubstr("mask_queries"));
  model.classes = {"wall", "chair", "lamp", "no object"};
  EXPECT_EQ(recognise(outputs(), model, "instance").decoder, "mask_queries");
}

}  // namespace
}  // namespace panoptic
