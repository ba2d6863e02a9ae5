// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map/object_registry.h"

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
  for (std::size_t z = 0; z < detections.size(); ++z) ASSERT_EQ(registry.create(), static_cast<PanopticId>(kFirst + z));
  for (int t = 0; t < 300; ++t) {
    const std::size_t z = random() % detections.size();
    Segment segment = seen(kChair, unit(random));
    float sum = 0;
    for (const ClassId l : {kBed, kChair, kTable})
      sum += segment.class_probabilities.emplace_back(ClassProbability{l, unit(random)}).probability;
    for (ClassProbability& p : segment.class_probabilities) p.probability /= sum;
    detections[z].push_back(segment);
    registry.observe(static_cast<PanopticId>(kFirst + z), segment, t);
  }
  for (std::size_t z = 0; z < detections.size(); ++z) {
    const auto id = static_cast<PanopticId>(kFirst + z);
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
  const PanopticId id = *registry.create();
  registry.observe(id, seen(kTable, 0.75F), 0);
  registry.observe(id, seen(kChair, 0.25F), 1);
  EXPECT_EQ(registry.probabilities(id), (std::vector<ClassProbability>{{kChair, 0.25F}, {kTable, 0.75F}}));
  EXPECT_EQ(registry.class_of(id), kTable);
}

TEST(ObjectRegistry, ReliableDetectionsOutweighManyPoorOnes) {
  ObjectRegistry registry(kFirst);
  const PanopticId id = *registry.create();
  for (int t = 0; t < 3; ++t) registry.observe(id, seen(kBed, 0.2F), t);
  registry.observe(id, seen(kTable, 0.9F), 3);
  EXPECT_EQ(registry.class_of(id), kTable);
}

TEST(ObjectRegistry, TiesGoToTheLowerClass) {
  ObjectRegistry registry(kFirst);
  const PanopticId id = *registry.create();
  registry.observe(id, seen(kTable, 0.5F), 0);
  registry.observe(id, seen(kChair, 0.5F), 1);
  EXPECT_EQ(registry.class_of(id), kChair);
}

TEST(ObjectRegistry, ObjectsWithoutEvidenceAndStrangersAreUnknown) {
  ObjectRegistry registry(kFirst);
  const PanopticId id = *registry.create();
  EXPECT_EQ(registry.class_of(id), ClassId::kUnknown);
  EXPECT_TRUE(registry.probabilities(id).empty());
  for (const PanopticId stranger : {PanopticId::kUnknown, PanopticId{kFirst - 1}, PanopticId{kFirst + 1}, PanopticId{65535}}) {
    EXPECT_EQ(registry.find(stranger), nullptr);
    EXPECT_EQ(registry.class_of(stranger), ClassId::kUnknown);
    EXPECT_TRUE(registry.probabilities(stranger).empty());
  }
}

TEST(ObjectRegistry, RemembersWhenAnObjectWasSeen) {
  ObjectRegistry registry(kFirst);
  const PanopticId id = *registry.create();
  for (const std::int64_t frame : {30, 10, 20}) registry.observe(id, seen(kChair, 1), frame);
  const Object* object = registry.find(id);
  ASSERT_NE(object, nullptr);
  EXPECT_EQ(object->id, id);
  EXPECT_EQ(object->first_frame, 10);
  EXPECT_EQ(object->last_frame, 30);
  EXPECT_EQ(object->observations, 3U);
}

TEST(ObjectRegistry, IdsCountUpUntilTheSixteenBitsAreUsed) {
  ObjectRegistry registry(kFirst);
  std::uint32_t expected = kFirst;
  while (const std::optional<PanopticId> id = registry.create()) {
    ASSERT_EQ(number(*id), expected++);
    ASSERT_NE(*id, PanopticId::kNoVote);
  }
  EXPECT_EQ(expected, 65535U);
  EXPECT_EQ(registry.create(), std::nullopt);
  EXPECT_EQ(registry.count(), 65535U - kFirst);
  EXPECT_NE(registry.find(PanopticId{65534}), nullptr);
  EXPECT_EQ(registry.find(PanopticId::kNoVote), nullptr);
}

TEST(ObjectRegistry, ForgetsUnusedObjectsAndReusesTheirIdsOnlyWhenAllAreGiven) {
  ObjectRegistry registry(kFirst);
  for (int i = 0; i < 3; ++i) registry.observe(*registry.create(), seen(kChair, 1), i);
  std::vector<bool> in_use(65536, false);
  in_use[kFirst + 1U] = true;
  registry.retire_unused(in_use);
  EXPECT_EQ(registry.count(), 1U);
  EXPECT_EQ(registry.find(static_cast<PanopticId>(kFirst)), nullptr);
  EXPECT_EQ(registry.class_of(static_cast<PanopticId>(kFirst)), ClassId::kUnknown);
  EXPECT_EQ(registry.class_of(static_cast<PanopticId>(kFirst + 1)), kChair);
  EXPECT_EQ(number(*registry.create()), kFirst + 3) << "a fresh id while there are any";
  while (registry.find(PanopticId{65534}) == nullptr) registry.create();
  EXPECT_EQ(number(*registry.create()), kFirst);
  EXPECT_EQ(number(*registry.create()), kFirst + 2);
  EXPECT_EQ(registry.create(), std::nullopt);
  EXPECT_EQ(registry.find(static_cast<PanopticId>(kFirst))->observations, 0U) << "nothing of the old object is left";
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

}  // namespace
}  // namespace panoptic
