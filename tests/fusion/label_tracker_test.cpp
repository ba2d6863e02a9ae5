// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/label_tracker.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

#include "tests/fusion/scenes.h"

namespace panoptic {
namespace {

constexpr int kWidth = 40;
constexpr int kHeight = 30;

RegisteredFrame registered_with(std::vector<std::uint16_t> segment) {
  RegisteredFrame r;
  r.width = kWidth;
  r.height = kHeight;
  r.depth.assign(r.pixel_count() + 1, 1.0F);
  r.color.assign(r.pixel_count() + 1, 0xFF000000U);
  r.segment = std::move(segment);
  r.segment.push_back(RegisteredFrame::kNoSegment);
  return r;
}

Segment chair(float score = 0.9F) { return {ClassId{3}, score, {{ClassId{3}, 1.0F}}}; }
Segment wall() { return {ClassId{1}, 1.0F, {}}; }

std::vector<LabelSlot> filled(LabelSlot id) { return std::vector<LabelSlot>(kWidth * kHeight, id); }

// Eq. 3-5 with sets of pixels, as the paper writes them.
std::vector<LabelSlot> naive_tracking(const RegisteredFrame& frame, const std::vector<Segment>& segments,
                                      const std::vector<LabelSlot>& reference, const LabelSet& labels, std::uint16_t next_id) {
  std::map<std::size_t, std::set<std::size_t>> mask;         // {u | L_t(u) = z}
  std::map<LabelSlot, std::set<std::size_t>> object_pixels;  // {u | L~_{t-1}(u) = z~}
  for (std::size_t i = 0; i < reference.size(); ++i) {
    if (frame.segment[i] == RegisteredFrame::kNoSegment) continue;
    if (frame.segment[i] > 0) mask[frame.segment[i] - 1U].insert(i);
    if (labels.is_object(reference[i])) object_pixels[reference[i]].insert(i);
  }
  std::vector<std::size_t> order;
  for (const auto& [s, pixels] : mask) {
    if (labels.is_thing(segments[s].class_id)) order.push_back(s);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return mask[a].size() > mask[b].size(); });
  std::map<std::size_t, LabelSlot> assigned;
  std::set<LabelSlot> taken;
  for (const std::size_t s : order) {
    double best = 0.25;
    std::optional<LabelSlot> match;
    for (const auto& [id, pixels] : object_pixels) {
      if (taken.contains(id)) continue;
      double both = 0;
      for (const std::size_t i : mask[s]) both += pixels.contains(i) ? 1 : 0;
      const double iou = both / (static_cast<double>(mask[s].size() + pixels.size()) - both);
      if (iou > best) {
        best = iou;
        match = id;
      }
    }
    assigned[s] = match.value_or(LabelSlot{next_id});
    if (!match) next_id++;
    taken.insert(assigned[s]);
  }
  std::vector<LabelSlot> result;
  for (const std::uint16_t value : frame.segment) {
    LabelSlot id = LabelSlot::kUnknown;
    if (value == RegisteredFrame::kNoSegment) {
      id = LabelSlot::kNoVote;
    } else if (value > 0 && labels.is_stuff(segments[value - 1U].class_id)) {
      id = LabelSet::of_class(segments[value - 1U].class_id);
    } else if (value > 0) {
      id = assigned.at(value - 1U);
    }
    result.push_back(id);
  }
  return result;
}

TEST(LabelTracker, EqualsTheNaiveReferenceOnRandomFrames) {
  const LabelSet labels = test::test_labels();
  std::mt19937 random(7);
  for (int trial = 0; trial < 60; ++trial) {
    ObjectRegistry objects(labels.first_thing());
    const int known = 1 + static_cast<int>(random() % 5);
    for (int k = 0; k < known; ++k) objects.create();
    std::vector<Segment> segments;
    for (int s = 0; s < 6; ++s) segments.push_back(random() % 4 == 0 ? wall() : chair());
    // Blobs: coarse cells of pixels share their segment and mostly their object, so that IoUs spread over the threshold.
    std::vector<std::uint16_t> segment(kWidth * kHeight);
    std::vector<LabelSlot> reference(kWidth * kHeight);
    std::vector<std::uint16_t> cell_segment(48), cell_object(48);
    for (std::size_t c = 0; c < 48; ++c) {
      cell_segment[c] = static_cast<std::uint16_t>(random() % 7);
      cell_object[c] = static_cast<std::uint16_t>(
          random() % 3 == 0 ? random() % 2 : 4 + (cell_segment[c] + random() % 2) % static_cast<unsigned>(known));
    }
    for (std::size_t i = 0; i < segment.size(); ++i) {
      const std::size_t cell = i % kWidth / 5 + i / kWidth / 5 * 8;
      segment[i] = random() % 50 == 0 ? RegisteredFrame::kNoSegment : cell_segment[cell];
      reference[i] = static_cast<LabelSlot>(cell_object[cell]);
    }
    const RegisteredFrame frame = registered_with(segment);
    const auto expected = naive_tracking(frame, segments, reference, labels, static_cast<std::uint16_t>(4 + known));
    LabelTracker tracker({.trust_map = false}, labels);
    ASSERT_EQ(tracker.assign(frame, segments, reference, 5, objects), expected) << "trial " << trial;
  }
}

TEST(LabelTracker, WhatSaysLessThanTheMapConfirmsTheMap) {
  const LabelSet labels = test::test_labels();
  ObjectRegistry objects(labels.first_thing());
  const LabelSlot unnamed = *objects.create();
  const LabelSlot named = *objects.create();
  objects.observe(named, chair(), 1);
  Segment chairs = chair();
  chairs.is_whole_class = true;
  // Three rows of segments (unknown, whole class, wall) over three columns of what the map knows.
  std::vector<std::uint16_t> segment(kWidth * kHeight, RegisteredFrame::kNoSegment);
  std::vector<LabelSlot> reference(kWidth * kHeight, LabelSlot::kUnknown);
  for (std::size_t i = 0; i < 9; ++i) {
    segment[i] = static_cast<std::uint16_t>(i / 3);
    reference[i] = i % 3 == 0 ? LabelSlot::kUnknown : i % 3 == 1 ? unnamed : named;
  }
  LabelTracker tracker({}, labels);
  const auto& ids = tracker.assign(registered_with(segment), std::vector<Segment>{chairs, wall()}, reference, 2, objects);
  const LabelSlot any_chair = LabelSet::of_class(chairs.class_id);
  const LabelSlot of_wall = LabelSet::of_class(wall().class_id);
  const std::vector<LabelSlot> expected = {
      LabelSlot::kUnknown, unnamed, LabelSlot::kUnknown, any_chair, any_chair, named, of_wall, of_wall, of_wall};
  EXPECT_EQ(std::vector<LabelSlot>(ids.begin(), ids.begin() + 9), expected);
  EXPECT_EQ(ids[9], LabelSlot::kNoVote);
}

TEST(LabelTracker, NoObjectIsTakenTwice) {
  const LabelSet labels = test::test_labels();
  ObjectRegistry objects(labels.first_thing());
  const LabelSlot object = *objects.create();
  std::vector<std::uint16_t> segment(kWidth * kHeight);
  for (std::size_t i = 0; i < segment.size(); ++i) segment[i] = i < segment.size() * 6 / 10 ? 1 : 2;
  LabelTracker tracker({}, labels);
  const auto& ids = tracker.assign(registered_with(segment), std::vector{chair(), chair()}, filled(object), 0, objects);
  EXPECT_EQ(ids.front(), object) << "the larger mask chooses first";
  EXPECT_EQ(ids[segment.size() - 1], LabelSlot{5}) << "the smaller one overlaps by IoU 0.4 but the object is taken";
}

TEST(LabelTracker, AnIouAtTheThresholdIsNotEnough) {
  const LabelSet labels = test::test_labels();
  ObjectRegistry objects(labels.first_thing());
  const LabelSlot object = *objects.create();
  std::vector<std::uint16_t> segment(kWidth * kHeight, 0);
  std::fill_n(segment.begin(), segment.size() / 4, std::uint16_t{1});
  LabelTracker tracker({}, labels);
  EXPECT_EQ(tracker.assign(registered_with(segment), std::vector{chair()}, filled(object), 0, objects).front(), LabelSlot{5});
  segment[segment.size() / 4] = 1;
  EXPECT_EQ(tracker.assign(registered_with(segment), std::vector{chair()}, filled(object), 1, objects).front(), object);
}

TEST(LabelTracker, AThingHiddenFromTheDepthCameraMakesNoObject) {
  const LabelSet labels = test::test_labels();
  ObjectRegistry objects(labels.first_thing());
  LabelTracker tracker({}, labels);
  tracker.assign(registered_with(std::vector<std::uint16_t>(kWidth * kHeight, 0)), std::vector{chair()},
                 filled(LabelSlot::kUnknown), 0, objects);
  EXPECT_EQ(objects.count(), 0U);
}

TEST(LabelTracker, WhenIdsRunOutTheRestHasNoVote) {
  const LabelSet labels = test::test_labels();
  ObjectRegistry objects(labels.first_thing());
  while (objects.create()) {
  }
  LabelTracker tracker({}, labels);
  const auto& ids = tracker.assign(registered_with(std::vector<std::uint16_t>(kWidth * kHeight, 1)), std::vector{chair()},
                                   filled(LabelSlot::kUnknown), 0, objects);
  EXPECT_EQ(ids.front(), LabelSlot::kNoVote);
}

TEST(LabelTracker, GathersEvidenceForTheAssignedObject) {
  const LabelSet labels = test::test_labels();
  ObjectRegistry objects(labels.first_thing());
  LabelTracker tracker({}, labels);
  const RegisteredFrame frame = registered_with(std::vector<std::uint16_t>(kWidth * kHeight, 1));
  tracker.assign(frame, std::vector{chair(0.5F)}, filled(LabelSlot::kUnknown), 3, objects);
  tracker.assign(frame, std::vector{chair(0.25F)}, filled(LabelSlot{4}), 9, objects);
  const Object* object = objects.find(LabelSlot{4});
  ASSERT_NE(object, nullptr);
  EXPECT_EQ(object->observations, 2U);
  EXPECT_EQ(object->first_frame, 3);
  EXPECT_EQ(object->last_frame, 9);
  EXPECT_DOUBLE_EQ(object->score_sum, 0.75);
  EXPECT_EQ(objects.class_of(LabelSlot{4}), ClassId{3});
}

}  // namespace
}  // namespace panoptic
