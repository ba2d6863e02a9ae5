// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panoptic/predict/class_names.h"
#include "panoptic/predict/decoders.h"
#include "tests/expect_error.h"

namespace panoptic {
namespace {

using test::error_of;
using testing::HasSubstr;

constexpr auto kCup = static_cast<ClassId>(5);
constexpr auto kChair = static_cast<ClassId>(8);
const std::vector<std::string> kNames = {"lamp", "cup", "chair"};
const std::vector<ClassId> kClassOf = {ClassId::kUnknown, kCup, kChair};
const Placement kHalf{200, 160, 100, 80, 0.5, 0.5};  // the image is twice the input

Model detector(std::vector<std::string> classes = kNames) {
  Model model;
  model.path = "rcnn.toml";
  model.classes = std::move(classes);
  model.input.width = 100;
  model.input.height = 80;
  return model;
}

// One detection: a box of 20 x 16 pixels of the input, its mask in the left half.
struct Parts {
  Tensor boxes{{1, 4}, {10, 20, 30, 36}, "boxes"};
  Tensor labels{{1}, {2}, "labels", true};
  Tensor scores{{1}, {0.9F}, "scores"};
  Tensor masks{{1, 1, 28, 28}, std::vector<float>(784), "masks"};

  explicit Parts(float label = 2) {
    labels.values[0] = label;
    for (std::size_t i = 0; i < masks.values.size(); ++i) masks.values[i] = i % 28 < 14 ? 1.0F : 0.0F;
  }
};

std::vector<Instance> instances_in(std::vector<Tensor> outputs, const Model& model = detector(),
                                   const std::vector<ClassId>& class_of = kClassOf) {
  const Reading reading = recognise(outputs, model, "instance");
  return decode(std::move(outputs), reading, {model, class_of, kHalf}).instances;
}

void expect_left_half(const std::vector<Instance>& instances, ClassId id) {
  ASSERT_EQ(instances.size(), 1U);
  EXPECT_EQ(instances[0].segment.class_id, id);
  EXPECT_FLOAT_EQ(instances[0].segment.score, 0.9F);
  EXPECT_EQ(instances[0].x0, 20);
  EXPECT_EQ(instances[0].y0, 40);
  ASSERT_EQ(instances[0].mask.width(), 40);
  ASSERT_EQ(instances[0].mask.height(), 32);
  for (int v = 0; v < 32; ++v) {
    for (int u = 0; u < 40; ++u) {
      const bool is_edge = u == 19 || u == 20;
      EXPECT_TRUE(is_edge || (instances[0].mask(u, v) != 0) == (u < 20)) << u << " " << v;
    }
  }
}

TEST(MaskRcnn, OfTheModelZooNumbersClassesFromOneAndDrawsMasksInTheirBoxes) {
  Parts p;
  expect_left_half(instances_in({p.boxes, p.labels, p.scores, p.masks}), kCup);
  p.boxes.name = p.labels.name = p.scores.name = p.masks.name = "6568";  // the zoo's names are numbers: the order tells
  expect_left_half(instances_in({p.boxes, p.labels, p.scores, p.masks}), kCup);
}

TEST(MaskRcnn, OfDetectron2NumbersClassesFromZero) {
  Parts p;
  const Tensor size{{2}, {80, 100}, "size", true};
  for (Tensor* t : {&p.boxes, &p.labels, &p.scores, &p.masks}) t->name = "1234";
  expect_left_half(instances_in({p.boxes, p.labels, p.masks, p.scores, size}), kChair);  // sorted by the names that it lost
  p.labels.name = "pred_classes";
  expect_left_half(instances_in({p.boxes, p.labels, p.scores, p.masks}), kChair);
}

TEST(MaskRcnn, OfMmdetectionHasTheScoreBesideTheBox) {
  const Parts p;
  const Tensor dets{{1, 1, 5}, {10, 20, 30, 36, 0.9F}, "dets"};
  const Tensor labels{{1, 1}, {2}, "labels", true};
  expect_left_half(instances_in({dets, labels, p.masks}), kChair);
}

TEST(MaskRcnn, OfTorchvisionHasMasksOverTheInputAndCocoCategories) {
  const std::vector<std::string> coco = class_lists_of(80).front().classes;
  std::vector<ClassId> class_of(80, ClassId::kUnknown);
  class_of[56] = kChair;  // category 62
  Parts p(62);
  p.masks = Tensor{{1, 1, 80, 100}, std::vector<float>(8000), "masks"};
  for (std::size_t i = 0; i < 8000; ++i) p.masks.values[i] = i % 100 >= 10 && i % 100 < 20 ? 1.0F : 0.0F;
  expect_left_half(instances_in({p.boxes, p.labels, p.scores, p.masks}, detector(coco), class_of), kChair);
}

TEST(MaskRcnn, CountsABackgroundThatTheDescriptionLists) {
  const Parts p(3);
  const std::vector<ClassId> class_of = {ClassId::kUnknown, ClassId::kUnknown, kCup, kChair};
  expect_left_half(
      instances_in({p.boxes, p.labels, p.scores, p.masks}, detector({"__background__", "lamp", "cup", "chair"}), class_of),
      kChair);
}

TEST(MaskRcnn, MayFindNothing) {
  const std::vector<Tensor> none = {Tensor{{0, 4}, {}, "boxes"}, Tensor{{0}, {}, "labels", true}, Tensor{{0}, {}, "scores"},
                                    Tensor{{0, 1, 80, 100}, {}, "masks"}};
  EXPECT_TRUE(instances_in(none).empty());
}

TEST(MaskRcnn, WeighsClassesWithTheProbabilityThatThereIsAnObject) {
  Parts p;
  // Background first, as classes are numbered from one: lamp .1, cup .5, chair .2.
  const Tensor first{{1, 4}, {0.2F, 0.1F, 0.5F, 0.2F}, "class_probs"};
  std::vector<Instance> found = instances_in({p.boxes, p.labels, p.scores, p.masks, first});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_FLOAT_EQ(found[0].segment.score, 0.8F);
  ASSERT_EQ(found[0].segment.class_probabilities.size(), 2U);
  EXPECT_EQ(found[0].segment.class_probabilities[0].class_id, kCup);
  EXPECT_NEAR(found[0].segment.class_probabilities[0].probability, 0.5 / 0.7, 1e-6);
  EXPECT_NEAR(found[0].segment.class_probabilities[1].probability, 0.2 / 0.7, 1e-6);
  // Background last, as detectron2 has it.
  p.labels.name = "pred_classes";
  const Tensor last{{1, 4}, {0.1F, 0.2F, 0.5F, 0.2F}, "class_probs"};
  found = instances_in({p.boxes, p.labels, p.scores, p.masks, last});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_FLOAT_EQ(found[0].segment.score, 0.8F);
}

TEST(MaskRcnn, RefusesNumbersOfClassesThatCannotBe) {
  const Parts zero(0);
  EXPECT_THAT(error_of([&] {
                instances_in({zero.boxes, zero.labels, zero.scores, zero.masks});
              }),
              HasSubstr("first_class = \"0\""));
  const Parts many(9);
  EXPECT_THAT(error_of([&] { instances_in({many.boxes, many.labels, many.scores, many.masks}); }), HasSubstr("3 classes"));
  Parts odd;
  for (Tensor* t : {&odd.boxes, &odd.labels, &odd.scores, &odd.masks}) t->name = "x";
  EXPECT_THAT(error_of([&] { instances_in({odd.scores, odd.masks, odd.labels, odd.boxes}); }), HasSubstr("first_class"));
}

TEST(MaskRcnn, RefusesScoresAndLabelsInEachOthersPlace) {
  Parts p;
  p.labels = Tensor{{1}, {0.9F}, "labels"};
  p.scores = Tensor{{1}, {2}, "scores"};
  EXPECT_THAT(error_of([&] { instances_in({p.boxes, p.labels, p.scores, p.masks}); }), HasSubstr("2 as the score"));
  const Parts good;
  const Tensor fraction{{1}, {1.5F}, "pred_classes"};
  EXPECT_THAT(error_of([&] { instances_in({good.boxes, fraction, good.scores, good.masks}); }), HasSubstr("class number 1.5"));
}

TEST(MaskRcnn, TakesTheMaskOfItsClassForASingleDetectionToo) {
  const Parts p;
  Tensor per_class{{1, 3, 28, 28}, std::vector<float>(3 * 784), "masks"};
  std::copy(p.masks.values.begin(), p.masks.values.end(), per_class.values.begin() + 784);
  expect_left_half(instances_in({p.boxes, p.labels, p.scores, per_class}), kCup);
}

TEST(MaskRcnn, RefusesAnOutputThatDoesNotFitTheRoleThatTheDescriptionGivesIt) {
  const Parts p;
  for (const char* role : {"masks", "boxes", "labels", "scores", "distribution"}) {
    Model model = detector();
    const bool may_be_boxes = role == std::string("boxes") || role == std::string("distribution");  // four columns
    model.outputs[role] = may_be_boxes ? "masks" : "boxes";
    EXPECT_THAT(error_of([&] {
                  instances_in({p.boxes, p.labels, p.scores, p.masks}, model);
                }),
                HasSubstr("does not have"))
        << role;
  }
  const Tensor no_cells{{1, 1, 0, 28}, {}, "masks"};
  EXPECT_THAT(error_of([&] { instances_in({p.boxes, p.labels, p.scores, no_cells}); }), HasSubstr("no masks"));
}

TEST(MaskRcnn, SaysWhatIsMissing) {
  const Parts p;
  EXPECT_THAT(error_of([&] { instances_in({p.boxes, p.labels, p.scores}); }), HasSubstr("no masks"));
}

}  // namespace
}  // namespace panoptic
