// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects/object_views.h"

#include <gtest/gtest.h>

#include <random>

namespace panoptic {
namespace {

constexpr std::uint16_t kFirst = 4;
constexpr ClassId kChair{3};

// Rectangles of segments on top of each other, thrown at random.
Segmentation random_segmentation(std::mt19937_64& random, std::size_t segments) {
  Segmentation s{Image<std::uint16_t>(40, 30), {}};
  for (std::size_t i = 0; i < segments; ++i) {
    s.segments.push_back({kChair, static_cast<float>(1 + random() % 9) / 10, {}});
    const int u0 = static_cast<int>(random() % 40);
    const int v0 = static_cast<int>(random() % 30);
    for (int v = v0; v < std::min(30, v0 + 12); ++v) {
      for (int u = u0; u < std::min(40, u0 + 9); ++u) s.segment_at(u, v) = static_cast<std::uint16_t>(i + 1);
    }
  }
  return s;
}

PixelBox naive_box(const Image<std::uint16_t>& segment_at, std::size_t value) {
  PixelBox box{1000, 1000, 0, 0};
  for (int v = 0; v < segment_at.height(); ++v) {
    for (int u = 0; u < segment_at.width(); ++u) {
      if (segment_at(u, v) == value)
        box = {std::min(box.u0, u), std::min(box.v0, v), std::max(box.u1, u + 1), std::max(box.v1, v + 1)};
    }
  }
  return box;
}

TEST(RecordViews, KeepsTheBoxesOfTheLargestSightsOfEachObject) {
  std::mt19937_64 random(2);
  ObjectRegistry objects(kFirst);
  std::vector<BestViews> expected(4);
  for (std::size_t i = 0; i < expected.size(); ++i) objects.create();
  for (std::int64_t frame = 0; frame < 60; ++frame) {
    const Segmentation s = random_segmentation(random, expected.size());
    std::vector<LabelSlot> ids;
    std::vector<std::uint32_t> visible;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      ids.push_back(static_cast<LabelSlot>(kFirst + (i + static_cast<std::size_t>(frame)) % expected.size()));
      visible.push_back(
          static_cast<std::uint32_t>(std::count(s.segment_at.pixels().begin(), s.segment_at.pixels().end(), i + 1)));
      if (visible.back() == 0) continue;
      expected[number(ids.back()) - kFirst].add(
          {frame, kChair, s.segments[i].score, visible.back(), naive_box(s.segment_at, i + 1)});
    }
    record_views(s, {frame, ids, visible}, objects);
  }
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const Object* object = objects.find(static_cast<LabelSlot>(kFirst + i));
    EXPECT_EQ(object->best_views.views().size(), 3U);
    EXPECT_EQ(object->best_views, expected[i]);
  }
}

TEST(RecordViews, LeavesStuffAndTheUnseenAlone) {
  ObjectRegistry objects(kFirst);
  const LabelSlot chair = *objects.create();
  const Segmentation s{Image<std::uint16_t>(4, 4, 1), {{ClassId{1}, 1, {}}, {kChair, 1, {}}, {kChair, 1, {}}}};
  const std::vector<LabelSlot> ids = {LabelSlot{1}, chair, LabelSlot::kNoVote};
  const std::vector<std::uint32_t> visible = {16, 0, 3};
  record_views(s, {0, ids, visible}, objects);
  EXPECT_TRUE(objects.find(chair)->best_views.views().empty());
}

TEST(RecordViews, TakesAFrameWithoutAPrediction) {
  ObjectRegistry objects(kFirst);
  record_views({}, {}, objects);
  EXPECT_EQ(objects.count(), 0U);
}

}  // namespace
}  // namespace panoptic
