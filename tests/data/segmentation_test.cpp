// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/segmentation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

namespace panoptic {
namespace {

constexpr ClassId kWall{1};
constexpr ClassId kFloor{2};
constexpr ClassId kChair{3};
constexpr ClassId kTable{4};

LabelSet labels() {
  return {"test",
          {{kWall, "wall", false, {}}, {kFloor, "floor", false, {}}, {kChair, "chair", true, {}}, {kTable, "table", true, {}}}};
}

Instance box(ClassId class_id, float score, std::array<int, 4> x0_y0_width_height) {
  const auto [x0, y0, width, height] = x0_y0_width_height;
  return {{class_id, score, {}}, x0, y0, Image<std::uint8_t>(width, height, 1)};
}

bool covers(const Instance& instance, int u, int v) {
  const int x = u - instance.x0;
  const int y = v - instance.y0;
  return x >= 0 && x < instance.mask.width() && y >= 0 && y < instance.mask.height() && instance.mask(x, y) != 0;
}

// Z_t(u): the instance in front at a pixel; -1 stands for the unknown label.
int instance_at(const std::vector<Instance>& instances, const LabelSet& set, int u, int v) {
  int front = -1;
  for (int z = 0; z < static_cast<int>(instances.size()); ++z) {
    const Segment& segment = instances[z].segment;
    if (!set.is_thing(segment.class_id) || std::isnan(segment.score) || !covers(instances[z], u, v)) continue;
    if (front < 0 || segment.score > instances[front].segment.score) front = z;
  }
  return front;
}

constexpr SegmentationOptions kAsInThePaper{.keep_whole_classes = false, .smaller_in_front = false};

// Eq. 1 as the paper writes it, one pixel at a time, against what fuse says about that pixel.
void expect_equation_1(const Image<ClassId>& semantic, const std::vector<Instance>& instances, const LabelSet& set) {
  const Segmentation fused = fuse(semantic, instances, set, kAsInThePaper);
  ASSERT_EQ(check(fused, semantic.width(), semantic.height()).reason, "");
  std::vector<int> owner(fused.segments.size(), -1);
  for (int v = 0; v < semantic.height(); ++v) {
    for (int u = 0; u < semantic.width(); ++u) {
      const int z = instance_at(instances, set, u, v);
      const std::uint16_t segment = fused.segment_at(u, v);
      if (z >= 0) {
        ASSERT_GT(segment, 0) << u << " " << v;
        ASSERT_EQ(fused.segments[segment - 1], instances[z].segment);
        ASSERT_TRUE(owner[segment - 1] == -1 || owner[segment - 1] == z) << "two instances share a segment";
        owner[segment - 1] = z;
      } else if (set.is_stuff(semantic(u, v))) {
        ASSERT_GT(segment, 0) << u << " " << v;
        ASSERT_EQ(fused.segments[segment - 1], (Segment{semantic(u, v), 1.0F, {}}));
      } else {
        ASSERT_EQ(segment, 0) << u << " " << v;
      }
    }
  }
  for (std::size_t s = 1; s <= fused.segments.size(); ++s) {
    const auto pixels = fused.segment_at.pixels();
    ASSERT_NE(std::find(pixels.begin(), pixels.end(), static_cast<std::uint16_t>(s)), pixels.end())
        << "segment " << s << " keeps no pixel";
  }
}

TEST(Fuse, EqualsEquationOneOnRandomInput) {
  std::mt19937 random(11);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  for (int trial = 0; trial < 200; ++trial) {
    Image<ClassId> semantic(24, 17);
    for (std::size_t i = 0; i < semantic.size(); ++i) semantic[i] = static_cast<ClassId>(below(7));  // 0, stuff, things, no class
    std::vector<Instance> instances(static_cast<std::size_t>(below(9)));
    for (Instance& instance : instances) {
      instance.segment = {static_cast<ClassId>(below(6)), static_cast<float>(below(4)) / 3, {{kChair, 0.25F}, {kTable, 0.75F}}};
      instance.x0 = below(40) - 10;  // partly and wholly outside too
      instance.y0 = below(40) - 10;
      instance.mask = Image<std::uint8_t>(below(12), below(12));
      for (std::size_t i = 0; i < instance.mask.size(); ++i) instance.mask[i] = static_cast<std::uint8_t>(below(3));
    }
    expect_equation_1(semantic, instances, labels());
    if (HasFatalFailure()) FAIL() << "trial " << trial;
  }
}

TEST(Fuse, PutsTheHigherScoreInFrontAndTheEarlierOneAtATie) {
  const Image<ClassId> nothing(4, 1);
  const std::vector<Instance> instances = {box(kChair, 0.5F, {0, 0, 2, 1}), box(kTable, 0.9F, {1, 0, 2, 1}),
                                           box(kChair, 0.9F, {2, 0, 2, 1})};
  const Segmentation fused = fuse(nothing, instances, labels());
  EXPECT_EQ(fused.segment_at, (Image<std::uint16_t>(4, 1, {3, 1, 1, 2})));
  ASSERT_EQ(fused.segments.size(), 3U);
  EXPECT_EQ(fused.segments[0].class_id, kTable);
  EXPECT_EQ(fused.segments[2].score, 0.5F);
}

TEST(Fuse, OrdersThingsByScoreThenStuff) {
  Image<ClassId> semantic(4, 1, kFloor);
  semantic(3, 0) = kWall;
  const Segmentation fused = fuse(semantic, {box(kChair, 0.2F, {0, 0, 1, 1}), box(kTable, 0.8F, {1, 0, 1, 1})}, labels());
  ASSERT_EQ(fused.segments.size(), 4U);
  EXPECT_EQ(fused.segments[0].class_id, kTable);
  EXPECT_EQ(fused.segments[1].class_id, kChair);
  EXPECT_TRUE(labels().is_stuff(fused.segments[2].class_id));
  EXPECT_TRUE(labels().is_stuff(fused.segments[3].class_id));
}

TEST(Fuse, PutsTheSmallerMaskInFrontWhateverTheScores) {
  const std::vector<Instance> instances = {box(kTable, 0.9F, {0, 0, 4, 1}), box(kChair, 0.2F, {1, 0, 2, 1})};
  const Segmentation fused = fuse(Image<ClassId>(4, 1), instances, labels());
  EXPECT_EQ(fused.segment_at, (Image<std::uint16_t>(4, 1, {2, 1, 1, 2})));
  EXPECT_EQ(fused.segments[0].class_id, kChair);
  EXPECT_EQ(fuse(Image<ClassId>(4, 1), instances, labels(), kAsInThePaper).segments.size(), 1U);
}

TEST(Fuse, ASemanticThingWithoutAnInstanceKeepsItsClassAlone) {
  const Segmentation fused = fuse(Image<ClassId>(3, 2, kChair), {box(kTable, 1, {0, 0, 1, 1})}, labels());
  ASSERT_EQ(fused.segments.size(), 2U);
  EXPECT_EQ(fused.segment_at, (Image<std::uint16_t>(3, 2, {1, 2, 2, 2, 2, 2})));
  EXPECT_EQ(fused.segments[1], (Segment{kChair, 1.0F, {}, true}));
  EXPECT_FALSE(fused.segments[0].is_whole_class);
}

TEST(Fuse, ASemanticThingWithoutAnInstanceIsUnknownInThePaper) {
  const Segmentation fused = fuse(Image<ClassId>(3, 2, kChair), {}, labels(), kAsInThePaper);
  EXPECT_EQ(fused.segment_at, Image<std::uint16_t>(3, 2));
  EXPECT_TRUE(fused.segments.empty());
}

TEST(Fuse, DropsInstancesThatKeepNoPixel) {
  const std::vector<Instance> instances = {box(kChair, 0.9F, {0, 0, 3, 3}), box(kTable, 0.5F, {1, 1, 1, 1}),
                                           box(kChair, 0.4F, {9, 9, 2, 2}), box(kChair, 0.3F, {0, 0, 0, 0})};
  const Segmentation fused = fuse(Image<ClassId>(3, 3), instances, labels(), kAsInThePaper);
  ASSERT_EQ(fused.segments.size(), 1U);
  EXPECT_EQ(fused.segments[0], instances[0].segment);
}

TEST(Fuse, IgnoresInstancesOfStuffAndOfNoClass) {
  const Segmentation fused =
      fuse(Image<ClassId>(2, 1, kFloor), {box(kWall, 1, {0, 0, 2, 1}), box(ClassId{77}, 1, {0, 0, 2, 1})}, labels());
  ASSERT_EQ(fused.segments.size(), 1U);
  EXPECT_EQ(fused.segments[0].class_id, kFloor);
}

TEST(Fuse, DropsScoresThatAreNotANumber) {
  std::vector<Instance> instances;
  for (int i = 0; i < 100; ++i)
    instances.push_back(
        box(kChair, i % 3 == 0 ? std::numeric_limits<float>::quiet_NaN() : 0.01F * static_cast<float>(i), {i, 0, 1, 1}));
  const Segmentation fused = fuse(Image<ClassId>(100, 1), instances, labels());
  EXPECT_EQ(fused.segments.size(), 66U);
  EXPECT_TRUE(std::is_sorted(fused.segments.begin(), fused.segments.end(),
                             [](const Segment& a, const Segment& b) { return a.score > b.score; }));
}

TEST(Fuse, TakesMasksFarOutsideTheImage) {
  constexpr int kMost = std::numeric_limits<int>::max();
  constexpr int kLeast = std::numeric_limits<int>::min();
  const std::vector<Instance> instances = {box(kChair, 1, {kMost, kMost, 2, 2}), box(kChair, 1, {kLeast, kLeast, 2, 2}),
                                           box(kChair, 1, {kMost, 0, 2, 2})};
  EXPECT_TRUE(fuse(Image<ClassId>(2, 2), instances, labels()).segments.empty());
}

TEST(Fuse, NeverRunsOutOfSegmentNumbers) {
  constexpr int kStuffClasses = 999 - 1;
  std::vector<LabelClass> classes = {{ClassId{1}, "thing", true, {}}};
  for (int i = 2; i <= kStuffClasses + 1; ++i)
    classes.push_back({static_cast<ClassId>(i), "stuff " + std::to_string(i), false, {}});
  const LabelSet many("many", classes);
  std::vector<Instance> instances;
  for (int i = 0; i < 66000; ++i) instances.push_back(box(ClassId{1}, 0.5F, {i % 300, i / 300, 1, 1}));
  Image<ClassId> semantic(300, 300);
  for (std::size_t i = 0; i < semantic.size(); ++i) semantic[i] = static_cast<ClassId>(2 + i % kStuffClasses);
  const Segmentation fused = fuse(semantic, instances, many);
  EXPECT_EQ(check(fused, 300, 300).reason, "");
  ASSERT_GT(fused.segments.size(), std::size_t{kStuffClasses} + 60000);
  ASSERT_LE(fused.segments.size(), 65535U);
  for (std::size_t i = 66000; i < semantic.size(); ++i) {
    ASSERT_GT(fused.segment_at[i], 0);
    ASSERT_EQ(fused.segments[fused.segment_at[i] - 1U].class_id, semantic[i]);
  }
}

TEST(Fuse, OfNothingIsNothing) {
  const Segmentation fused = fuse(Image<ClassId>(), {}, labels());
  EXPECT_EQ(fused, Segmentation{});
  EXPECT_EQ(fuse(Image<ClassId>(), {box(kChair, 1, {0, 0, 2, 2})}, labels()), Segmentation{});
}

TEST(SegmentationWhyUnusable, AcceptsAnEmptyOneAndNamesEachFault) {
  EXPECT_EQ(check(Segmentation{}, 4, 3).reason, "");
  Segmentation segmentation{Image<std::uint16_t>(4, 3), {Segment{}}};
  EXPECT_EQ(check(segmentation, 4, 3).reason, "");
  EXPECT_EQ(check(segmentation, 3, 4).reason, "segmentation and colour image differ in size");
  segmentation.segment_at(3, 2) = 1;
  EXPECT_EQ(check(segmentation, 4, 3).reason, "");
  segmentation.segment_at(3, 2) = 2;
  EXPECT_EQ(check(segmentation, 4, 3).reason, "segmentation names a segment that does not exist");
}

}  // namespace
}  // namespace panoptic
