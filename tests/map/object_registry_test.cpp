// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects.h"

#include <gtest/gtest.h>

#include <random>

namespace panoptic {
namespace {

constexpr std::uint16_t kFirst = 40;
constexpr ClassId kBed{4};
constexpr ClassId kChair{5};
constexpr ClassId kTable{7};

Segment seen(ClassId class_id, float score) { return {class_id, score, {}}; }

// Eq. 12 as the paper writes it: the distribution over every detection of z, weighted by its foreground probability.
double equation_12(const std::vector<Segment>& detections, ClassId l) {
  double numerator = 0;
  double denominator = 0;
  for (const Segment& detection : detections) {
    for (const ClassProbability& p : detection.class_probabilities) {
      if (p.class_id == l) numerator += double{detection.score} * double{p.probability};
    }
    denominator += double{detection.score};
  }
  return numerator / denominator;
}

TEST(ObjectRegistry, ProbabilitiesAreEquationTwelve) {
  std::mt19937 random(6);
  std::uniform_real_distribution<float> unit(0.01F, 1);
  ObjectRegistry registry(kFirst);
  std::vector<std::vector<Segment>> detections(5);
  for (std::size_t z = 0; z < detections.size(); ++z) ASSERT_EQ(registry.create(), static_cast<LabelSlot>(kFirst + z));
  for (int t = 0; t < 300; ++t) {
    const std::size_t z = random() % detections.size();
    Segment segment = seen(kChair, unit(random));
    float sum = 0;
    for (const ClassId l : {kBed, kChair, kTable})
      sum += segment.class_probabilities.emplace_back(ClassProbability{l, unit(random)}).probability;
    for (ClassProbability& p : segment.class_probabilities) p.probability /= sum;
    detections[z].push_back(segment);
    registry.observe(static_cast<LabelSlot>(kFirst + z), segment, t);
  }
  for (std::size_t z = 0; z < detections.size(); ++z) {
    const auto id = static_cast<LabelSlot>(kFirst + z);
    const std::vector<ClassProbability> probabilities = registry.probabilities(id);
    ASSERT_EQ(probabilities.size(), 3U);
    double total = 0;
    ClassProbability best;
    for (const ClassProbability& p : probabilities) {
      EXPECT_NEAR(p.probability, equation_12(detections[z], p.class_id), 1e-6);
      total += double{p.probability};
      if (p.probability > best.probability) best = p;
    }
    EXPECT_NEAR(total, 1, 1e-5);
    EXPECT_EQ(registry.class_of(id), best.class_id);
  }
}

TEST(ObjectRegistry, ADetectionWithoutADistributionCountsForItsClass) {
  ObjectRegistry registry(kFirst);
  const LabelSlot id = *registry.create();
  registry.observe(id, seen(kTable, 0.75F), 0);
  registry.observe(id, seen(kChair, 0.25F), 1);
  EXPECT_EQ(registry.probabilities(id), (std::vector<ClassProbability>{{kChair, 0.25F}, {kTable, 0.75F}}));
  EXPECT_EQ(registry.class_of(id), kTable);
}

TEST(ObjectRegistry, ReliableDetectionsOutweighManyPoorOnes) {
  ObjectRegistry registry(kFirst);
  const LabelSlot id = *registry.create();
  for (int t = 0; t < 3; ++t) registry.observe(id, seen(kBed, 0.2F), t);
  registry.observe(id, seen(kTable, 0.9F), 3);
  EXPECT_EQ(registry.class_of(id), kTable);
}

TEST(ObjectRegistry, TiesGoToTheLowerClass) {
  ObjectRegistry registry(kFirst);
  const LabelSlot id = *registry.create();
  registry.observe(id, seen(kTable, 0.5F), 0);
  registry.observe(id, seen(kChair, 0.5F), 1);
  EXPECT_EQ(registry.class_of(id), kChair);
}

TEST(ObjectRegistry, ObjectsWithoutEvidenceAndStrangersAreUnknown) {
  ObjectRegistry registry(kFirst);
  const LabelSlot id = *registry.create();
  EXPECT_EQ(registry.class_of(id), ClassId::kUnknown);
  EXPECT_TRUE(registry.probabilities(id).empty());
  for (const LabelSlot stranger : {LabelSlot::kUnknown, LabelSlot{kFirst - 1}, LabelSlot{kFirst + 1}, LabelSlot{65535}}) {
    EXPECT_EQ(registry.find(stranger), nullptr);
    EXPECT_EQ(registry.class_of(stranger), ClassId::kUnknown);
    EXPECT_TRUE(registry.probabilities(stranger).empty());
  }
}

TEST(ObjectRegistry, RemembersWhenAnObjectWasSeen) {
  ObjectRegistry registry(kFirst);
  const LabelSlot id = *registry.create();
  for (const std::int64_t frame : {30, 10, 20}) registry.observe(id, seen(kChair, 1), frame);
  const Object* object = registry.find(id);
  ASSERT_NE(object, nullptr);
  EXPECT_EQ(object->slot, id);
  EXPECT_EQ(object->id, PanopticId{number(id)});
  EXPECT_EQ(object->first_frame, 10);
  EXPECT_EQ(object->last_frame, 30);
  EXPECT_EQ(object->observations, 3U);
}

TEST(ObjectRegistry, SlotsCountUpUntilTheSixteenBitsAreUsed) {
  ObjectRegistry registry(kFirst);
  std::uint32_t expected = kFirst;
  while (const std::optional<LabelSlot> id = registry.create()) {
    ASSERT_EQ(number(*id), expected++);
    ASSERT_NE(*id, LabelSlot::kNoVote);
  }
  EXPECT_EQ(expected, 65535U);
  EXPECT_EQ(registry.refused(), 1U);
  EXPECT_EQ(registry.create(), std::nullopt);
  EXPECT_EQ(registry.refused(), 2U) << "nothing is refused in silence";
  EXPECT_EQ(registry.count(), 65535U - kFirst);
  EXPECT_NE(registry.find(LabelSlot{65534}), nullptr);
  EXPECT_EQ(registry.find(LabelSlot::kNoVote), nullptr);
}

TEST(ObjectRegistry, ForgetsUnusedObjectsAndGivesTheirSlotsAnewOnlyWhenAllWereGiven) {
  ObjectRegistry registry(kFirst);
  for (int i = 0; i < 3; ++i) registry.observe(*registry.create(), seen(kChair, 1), i);
  std::vector<bool> in_use(65536, false);
  in_use[kFirst + 1U] = true;
  registry.retire_unused(in_use);
  EXPECT_EQ(registry.count(), 1U);
  EXPECT_EQ(registry.find(static_cast<LabelSlot>(kFirst)), nullptr);
  EXPECT_EQ(registry.class_of(static_cast<LabelSlot>(kFirst)), ClassId::kUnknown);
  EXPECT_EQ(registry.class_of(static_cast<LabelSlot>(kFirst + 1)), kChair);
  EXPECT_EQ(number(*registry.create()), kFirst + 3) << "a fresh slot while there are any";
  while (registry.find(LabelSlot{65534}) == nullptr) registry.create();
  EXPECT_EQ(number(*registry.create()), kFirst);
  EXPECT_EQ(number(*registry.create()), kFirst + 2);
  EXPECT_EQ(registry.create(), std::nullopt);
  const Object& anew = *registry.find(static_cast<LabelSlot>(kFirst));
  EXPECT_EQ(anew.observations, 0U) << "nothing of the old object is left";
  EXPECT_EQ(anew.id, PanopticId{65535}) << "the slot is an old one, the id is not";
  EXPECT_EQ(registry.find(PanopticId{kFirst}), nullptr);
}

TEST(ObjectRegistry, AsksForRetirementAfterManyCreations) {
  ObjectRegistry registry(kFirst);
  EXPECT_FALSE(registry.wants_retirement());
  for (int i = 0; i < 5000; ++i) registry.create();
  EXPECT_TRUE(registry.wants_retirement());
  registry.retire_unused(std::vector<bool>(65536, true));
  EXPECT_FALSE(registry.wants_retirement());
  EXPECT_EQ(registry.count(), 5000U);
}

// Two objects that were one all along: the merged one is what a single object would be that had seen everything.
TEST(ObjectRegistry, MergingGivesWhatOneObjectWouldBeThatSawEverything) {
  std::mt19937 random(7);
  ObjectRegistry apart(kFirst);
  ObjectRegistry whole(kFirst);
  const LabelSlot a = *apart.create();
  const LabelSlot b = *apart.create();
  const LabelSlot one = *whole.create();
  for (int t = 100; t > 0; --t) {
    const float score = static_cast<float>(random() % 8 + 1) / 8;  // sums of these are exact in any order
    Segment segment = seen(random() % 2 == 0 ? kChair : kTable, score);
    if (random() % 2 == 0) segment.class_probabilities = {{kChair, 0.25F}, {kTable, 0.75F}};
    const ObjectView view{t, segment.class_id, score, static_cast<std::uint32_t>(random() % 1000), {0, 0, 5, 5}};
    const LabelSlot part = random() % 3 == 0 ? a : b;
    apart.observe(part, segment, t);
    apart.show(part, view);
    whole.observe(one, segment, t);
    whole.show(one, view);
  }
  apart.merge(a, b, 199);
  const Object& merged = *apart.find(b);
  const Object& expected = *whole.find(one);
  EXPECT_EQ(merged.first_frame, expected.first_frame);
  EXPECT_EQ(merged.last_frame, expected.last_frame);
  EXPECT_EQ(merged.observations, expected.observations);
  EXPECT_EQ(merged.score_sum, expected.score_sum);
  EXPECT_EQ(merged.votes, expected.votes);
  EXPECT_EQ(merged.best_views, expected.best_views);
  EXPECT_EQ(apart.probabilities(b), whole.probabilities(one));
  EXPECT_EQ(apart.class_of(b), whole.class_of(one));
}

TEST(ObjectRegistry, MergingWithAnObjectThatWasNeverSeenKeepsTheTimes) {
  ObjectRegistry registry(kFirst);
  const LabelSlot seen_late = *registry.create();
  const LabelSlot never = *registry.create(3);
  EXPECT_EQ(registry.find(never)->first_frame, 3);
  const LabelSlot other = *registry.create();
  registry.observe(seen_late, seen(kChair, 1), 70);
  registry.merge(never, seen_late, 7);
  EXPECT_EQ(registry.find(seen_late)->first_frame, 70) << "not 0";
  registry.merge(seen_late, other, 7);
  EXPECT_EQ(registry.find(other)->first_frame, 70);
  EXPECT_EQ(registry.find(other)->last_frame, 70);
  EXPECT_EQ(registry.class_of(other), kChair);
}

TEST(ObjectRegistry, AMergedIdIsNoObjectButResolvesToItsSurvivorThroughChains) {
  ObjectRegistry registry(kFirst);
  std::vector<LabelSlot> ids;
  for (int i = 0; i < 5; ++i) ids.push_back(*registry.create());
  for (std::size_t i = 0; i < 3; ++i) registry.merge(ids[i], ids[i + 1], 7);
  EXPECT_EQ(registry.count(), 2U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(registry.survivor(ids[i]), ids[3]);
    EXPECT_EQ(registry.find(ids[i]) == nullptr, i < 3);
  }
  EXPECT_EQ(registry.survivor(ids[4]), ids[4]);
  for (const LabelSlot stranger : {LabelSlot::kUnknown, LabelSlot{kFirst - 1}, LabelSlot{kFirst + 5}, LabelSlot{65535}}) {
    EXPECT_EQ(registry.survivor(stranger), stranger);
  }
}

TEST(ObjectRegistry, ListsEveryMergedIdWithItsSurvivorAndEverySurvivorWithItsParts) {
  ObjectRegistry registry(kFirst);
  std::vector<LabelSlot> slots;
  for (int i = 0; i < 5; ++i) slots.push_back(*registry.create());
  const auto id = [&](std::size_t i) { return PanopticId{kFirst + static_cast<std::uint32_t>(i)}; };
  EXPECT_TRUE(registry.merged().empty());
  registry.merge(slots[3], slots[1], 7);
  registry.merge(slots[0], slots[4], 8);
  registry.merge(slots[1], slots[4], 9);
  using Merged = std::vector<MergedObject>;
  EXPECT_EQ(registry.merged(), (Merged{{id(0), id(4)}, {id(1), id(4)}, {id(3), id(4)}}));
  const PartHistory& parts = registry.find(slots[4])->parts;
  EXPECT_EQ(parts.latest(), (std::vector<ObjectPart>{{id(0), 8}, {id(3), 7}, {id(1), 9}}));
  EXPECT_EQ(parts.count(), 3U);
  EXPECT_EQ(registry.survivor(id(3)), id(4));
}

TEST(ObjectRegistry, ARuledOutClassGivesWayToTheNextLikelyOne) {
  ObjectRegistry registry(kFirst);
  const LabelSlot id = *registry.create();
  registry.observe(id, {kTable, 1, {{kBed, 0.3F}, {kChair, 0.2F}, {kTable, 0.5F}}}, 0);
  const std::vector<ClassProbability> before = registry.probabilities(id);
  registry.rule_out(id, {kTable});
  EXPECT_EQ(registry.class_of(id), kBed);
  registry.rule_out(id, {kTable, kBed});
  EXPECT_EQ(registry.class_of(id), kChair);
  registry.rule_out(id, {kTable, kBed, kChair});
  EXPECT_EQ(registry.class_of(id), ClassId::kUnknown);
  EXPECT_EQ(registry.probabilities(id), before) << "the evidence stays";
  registry.rule_out(id, {});
  EXPECT_EQ(registry.class_of(id), kTable);
}

TEST(ObjectRegistry, WhatIsLeftWhenTheLikelyAreRuledOutMustBeMoreThanNoise) {
  ObjectRegistry registry(kFirst);
  const LabelSlot id = *registry.create();
  registry.observe(id, {kTable, 1, {{kChair, 0.01F}, {kTable, 0.99F}}}, 0);
  registry.rule_out(id, {kTable});
  EXPECT_EQ(registry.class_of(id), ClassId::kUnknown);
}

}  // namespace
}  // namespace panoptic
