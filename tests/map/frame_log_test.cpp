// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map/frame_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "panoptic/error.h"

namespace panoptic {
namespace {

// Segments with ragged outlines: what row has which runs changes from row to row, and some rows are as the one above.
LoggedLabels ragged(std::mt19937& random, int width, int height) {
  LoggedLabels labels;
  const std::size_t count = 1 + random() % 200;
  for (std::size_t s = 0; s < count; ++s) {
    Segment segment{static_cast<ClassId>(random() % 40), static_cast<float>(random() % 100) / 100, {}, random() % 5 == 0};
    for (std::size_t p = random() % 4; p > 0; --p) {
      segment.class_probabilities.push_back({static_cast<ClassId>(p), static_cast<float>(random() % 100) / 400});
    }
    labels.segmentation.segments.push_back(segment);
    labels.ids.push_back(s % 17 == 3 ? LoggedLabels::kNoPlace : static_cast<PanopticId>(random()));
  }
  Image<std::uint16_t> image(width, height);
  for (int v = 0; v < height; ++v) {
    const bool anew = v == 0 || random() % 3 == 0;
    std::uint16_t value = 0;
    for (int u = 0; u < width; ++u) {
      if (random() % 20 == 0) value = static_cast<std::uint16_t>(random() % (count + 1));
      image(u, v) = anew ? value : image(std::clamp(u + static_cast<int>(random() % 50 == 0), 0, width - 1), v - 1);
    }
  }
  labels.segmentation.segment_at = std::move(image);
  return labels;
}

TEST(FrameLog, GivesLabelsBackAsTheyWere) {
  std::mt19937 random(1);
  for (int round = 0; round < 50; ++round) {
    const int width = 1 + static_cast<int>(random() % 200);
    const LoggedLabels labels = ragged(random, width, 1 + static_cast<int>(random() % 60));
    const FrameLog::Bytes bytes = encode_labels(labels.segmentation, labels.ids);
    const auto back = decode_labels(bytes);
    ASSERT_TRUE(back.has_value());
    EXPECT_EQ(back->segmentation, labels.segmentation);
    EXPECT_EQ(back->ids, labels.ids);
    const auto without = decode_labels(bytes, LoggedPixels::kLeftOut);
    EXPECT_EQ(without->segmentation.segments, labels.segmentation.segments);
    EXPECT_TRUE(without->segmentation.segment_at.empty());
  }
}

TEST(FrameLog, DamagedBytesAreLabelsOrNothing) {
  std::mt19937 random(2);
  const LoggedLabels labels = ragged(random, 90, 40);
  const FrameLog::Bytes bytes = encode_labels(labels.segmentation, labels.ids);
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    EXPECT_FALSE(decode_labels(std::span(bytes).first(length)).has_value());
  }
  for (int round = 0; round < 20000; ++round) {
    FrameLog::Bytes damaged = bytes;
    for (std::size_t n = 1 + random() % 4; n > 0; --n) damaged[random() % damaged.size()] = static_cast<std::uint8_t>(random());
    const auto back = decode_labels(damaged);
    if (!back) continue;
    const std::size_t segments = back->segmentation.segments.size();
    ASSERT_EQ(back->ids.size(), segments);
    for (const std::uint16_t value : back->segmentation.segment_at.pixels()) ASSERT_LE(value, segments);
  }
}

TEST(FrameLog, AStepOfAnOutlineBeyondEveryNumberIsRefused) {
  LoggedLabels labels;
  labels.segmentation.segments.resize(1);
  labels.ids.push_back(PanopticId{7});
  labels.segmentation.segment_at = Image<std::uint16_t>(4, 2);
  for (int v = 0; v < 2; ++v) labels.segmentation.segment_at(3, v) = 1;
  FrameLog::Bytes bytes = encode_labels(labels.segmentation, labels.ids);
  ASSERT_EQ(bytes.back(), 0);  // the end of the first run is that of the row above
  bytes.pop_back();
  for (const int byte : {0xFE, 0xFF, 0xFF, 0xFF, 0x0F}) bytes.push_back(static_cast<std::uint8_t>(byte));  // 2^31 - 1
  EXPECT_FALSE(decode_labels(bytes).has_value());
}

Frame frame_of(std::int64_t index) {
  Frame frame;
  frame.index = index;
  frame.time_s = 0.1 * static_cast<double>(index);
  return frame;
}

TEST(FrameLog, TellsWhatChangedAndIsTheSameFromItsEntries) {
  std::mt19937 random(3);
  FrameLog log(1'000'000);
  for (int i = 0; i < 5; ++i) log.add(frame_of(7 * i));
  const std::uint64_t before = log.clock();
  const LoggedLabels labels = ragged(random, 50, 20);
  log.set_labels(14, labels.segmentation, labels.ids);
  log.set_labels(15, labels.segmentation, labels.ids);  // not there
  Pose pose = Pose::Identity();
  pose.translation().x() = 1;
  log.set_pose(4, pose);
  std::vector<std::int64_t> changed;
  for (const FrameLog::Entry& entry : log.entries()) {
    if (entry.changed_at > before) changed.push_back(entry.frame);
  }
  EXPECT_THAT(changed, testing::ElementsAre(14, 28));

  const FrameLog restored(log.entries(), 1'000'000);
  EXPECT_EQ(restored.bytes(), log.bytes());
  EXPECT_EQ(restored.find(28), 4U);
  EXPECT_EQ(restored.labels(2)->ids, labels.ids);
  EXPECT_FALSE(restored.labels(1).has_value());
}

TEST(FrameLog, TakesNothingBeyondItsLimit) {
  FrameLog log(1000);
  for (int i = 0; i < 100; ++i) log.add(frame_of(i));
  EXPECT_LT(log.bytes(), 1500U);
  EXPECT_LT(log.size(), 10U);
  EXPECT_EQ(FrameLog(0).size(), 0U);
}

Frame with_images(std::int64_t index) {
  Frame frame = frame_of(index);
  frame.depth_camera = frame.color_camera = {200, 100, 100, 100, 100, 50};
  Image<float> depth(200, 100);
  std::mt19937 random(static_cast<std::uint32_t>(index));
  for (std::size_t i = 0; i < depth.size(); ++i) depth[i] = static_cast<float>(random() % 4096) * (1 / 1000.F);
  frame.depth = std::move(depth);
  frame.color = Image<Rgb>(200, 100, {1, 2, 3});
  return frame;
}

TEST(FrameLog, CopiesCountForTheLimitUnlessTheyGoToAFile) {
  FrameLog in_memory(200'000, LoggedCopies::kInMemory);
  FrameLog in_file(200'000, LoggedCopies::kInMemory);
  in_file.copy_to_file();
  for (int i = 0; i < 60; ++i) {
    in_memory.add(with_images(i));
    in_file.add(with_images(i));
  }
  EXPECT_EQ(in_memory.size(), 10U) << "six frames of some 33 kB, and four that were being packed";
  EXPECT_GT(in_memory.bytes(), 200'000U);
  EXPECT_EQ(in_file.size(), 60U);
  EXPECT_LT(in_file.bytes(), 20'000U);
  EXPECT_GT(in_file.packed_bytes(), 56U * 30'000U);
}

TEST(FrameLog, CopiesAreReadFromWhereTheyWereLeft) {
  FrameLog log(1'000'000, LoggedCopies::kInMemory);
  log.add(with_images(7));
  LoggedImages& images = *log.entries()[0].images;
  const Bytes packed = *images.packed();
  EXPECT_EQ(images.size(), packed.size());
  int reads = 0;
  images.let_go([&] {
    ++reads;
    return packed;
  });
  EXPECT_EQ(*images.packed(), packed);
  EXPECT_EQ(reads, 1);
  EXPECT_EQ(images.size(), packed.size());
}

}  // namespace
}  // namespace panoptic
