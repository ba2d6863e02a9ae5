// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/label_runs.h"

#include <gtest/gtest.h>

#include <random>

#include "panoptic/fusion/label_tracker.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

struct Pixels {
  std::vector<std::uint16_t> segment;
  std::vector<LabelSlot> reference;
};

// Runs of 1 to `longest` pixels; values from a handful, so that borders of the two images often fall together.
Pixels random_pixels(std::size_t count, unsigned longest, std::uint32_t seed) {
  std::mt19937 random(seed);
  Pixels pixels;
  std::uint16_t segment = 0;
  std::uint16_t reference = 0;
  while (pixels.segment.size() < count) {
    if (random() % 2 == 0) segment = random() % 8 == 0 ? RegisteredFrame::kNoSegment : static_cast<std::uint16_t>(random() % 3);
    if (random() % 2 == 0) reference = static_cast<std::uint16_t>(random() % 9);
    for (auto n = 1 + random() % longest; n > 0 && pixels.segment.size() < count; --n) {
      pixels.segment.push_back(segment);
      pixels.reference.push_back(static_cast<LabelSlot>(reference));
    }
  }
  return pixels;
}

std::vector<LabelRun> naive_runs(const Pixels& pixels, PixelRange range) {
  std::vector<LabelRun> runs;
  for (std::uint32_t i = range.begin; i < range.end; ++i) {
    const bool same =
        i > range.begin && pixels.segment[i] == pixels.segment[i - 1] && pixels.reference[i] == pixels.reference[i - 1];
    if (!same) runs.push_back({i, pixels.segment[i], pixels.reference[i]});
  }
  runs.push_back({range.end, 0, LabelSlot::kUnknown});
  return runs;
}

TEST(LabelRuns, AreThoseOfTheNaiveReference) {
  for (const unsigned longest : {1U, 4U, 40U, 3000U}) {
    const Pixels pixels = random_pixels(5000, longest, longest);
    for (const PixelRange range : {PixelRange{0, 5000}, {0, 1}, {7, 7}, {3, 516}, {100, 613}, {4999, 5000}}) {
      std::vector<LabelRun> runs;
      find_runs(pixels.segment, pixels.reference, range, runs);
      const std::vector<LabelRun> expected = naive_runs(pixels, range);
      ASSERT_EQ(runs.size(), expected.size()) << longest << " " << range.begin << ":" << range.end;
      for (std::size_t r = 0; r < runs.size(); ++r) {
        EXPECT_EQ(runs[r].begin, expected[r].begin);
        EXPECT_EQ(runs[r].segment, expected[r].segment);
        EXPECT_EQ(runs[r].reference, expected[r].reference);
      }
    }
  }
}

// Labels and areas of a frame with more columns than bands, and of a smaller one after it.
TEST(LabelRuns, GiveTheSameLabelsAtAnyThreadCount) {
  const LabelSet labels = load_label_set("indoor");
  std::vector<Segment> segments(2, Segment{labels.classes().back().id, 0.8F, {{labels.classes().back().id, 1.0F}}});
  const auto all_labels = [&](int threads) {
    set_thread_count(threads);
    ObjectRegistry objects(labels.first_thing());
    LabelTracker tracker({}, labels);
    std::vector<LabelSlot> result;
    for (const std::size_t count : {30000UL, 90UL, 7UL}) {
      Pixels pixels = random_pixels(count, 30, 5);
      for (LabelSlot& id : pixels.reference) id = static_cast<LabelSlot>(number(id) + labels.first_thing() - 2);
      for (int known = 0; known < 7; ++known) objects.create();
      RegisteredFrame frame;
      frame.width = static_cast<int>(count);
      frame.height = 1;
      frame.segment = pixels.segment;
      frame.segment.push_back(RegisteredFrame::kNoSegment);
      const auto& ids = tracker.assign(frame, segments, pixels.reference, 1, objects);
      EXPECT_EQ(ids.size(), count + 1);
      EXPECT_EQ(ids.back(), LabelSlot::kNoVote);
      result.insert(result.end(), ids.begin(), ids.end());
      for (const std::uint32_t area : tracker.segment_areas_px()) result.push_back(static_cast<LabelSlot>(area));
    }
    return result;
  };
  const std::vector<LabelSlot> alone = all_labels(1);
  EXPECT_EQ(all_labels(2), alone);
  EXPECT_EQ(all_labels(5), alone);
  set_thread_count(0);
}

}  // namespace
}  // namespace panoptic
