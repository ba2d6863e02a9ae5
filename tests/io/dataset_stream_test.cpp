// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "panoptic/error.h"
#include "panoptic/source.h"

namespace panoptic::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Frames that hold nothing but their position; every third cannot be used; reading position `broken` throws.
class Counting : public Dataset {
 public:
  explicit Counting(std::size_t size, std::size_t broken = SIZE_MAX) : size_(size), broken_(broken) {}

  std::string description() const override { return "counting"; }
  std::size_t size() const override { return size_; }
  ReadResult read(std::size_t position) const override {
    ++reads;
    if (position == broken_) throw Error("the disk is gone");
    const auto index = static_cast<std::int64_t>(position);
    if (position % 3 == 2) return {std::nullopt, {index, "every third"}};
    Frame frame;
    frame.index = index;
    return {frame, {}};
  }

  mutable std::atomic<std::size_t> reads = 0;

 private:
  std::size_t size_;
  std::size_t broken_;
};

std::vector<std::int64_t> indices(const Dataset& dataset, const std::string& range) {
  FrameStream stream(dataset, parse_frame_range(range));
  std::vector<std::int64_t> result;
  while (const auto next = stream.next()) result.push_back(next->frame ? next->frame->index : -next->skipped.index);
  return result;
}

std::string error_of(const std::string& range) {
  try {
    parse_frame_range(range);
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

TEST(FrameRange, CountsPositionsAndExcludesTheEnd) {
  EXPECT_EQ(parse_frame_range("10:20").count(500), 10U);
  EXPECT_EQ(parse_frame_range("10:20").count(15), 5U);
  EXPECT_EQ(parse_frame_range("::5").count(11), 3U);
  EXPECT_EQ(parse_frame_range(":100").count(500), 100U);
  EXPECT_EQ(parse_frame_range("3:").count(5), 2U);
  EXPECT_EQ(parse_frame_range(":").count(5), 5U);
  EXPECT_EQ(parse_frame_range("7:9").count(5), 0U);
  EXPECT_EQ(parse_frame_range("0:18446744073709551615:18446744073709551615").count(5), 1U);
}

TEST(FrameRange, SaysWhatIsWrong) {
  EXPECT_THAT(error_of("5:2"), HasSubstr("frame range '5:2': is empty"));
  EXPECT_THAT(error_of("5:5"), HasSubstr("is empty"));
  EXPECT_THAT(error_of("::0"), HasSubstr("the step is 0"));
  EXPECT_THAT(error_of("a:b"), HasSubstr("'a' is not a frame position"));
  EXPECT_THAT(error_of("-5:2"), HasSubstr("'-5' is not a frame position"));
  EXPECT_THAT(error_of("1.5:2"), HasSubstr("'1.5'"));
  EXPECT_THAT(error_of("99999999999999999999:"), HasSubstr("is not a frame position"));
  EXPECT_THAT(error_of("12"), HasSubstr("expected A:B or A:B:STEP"));
  EXPECT_THAT(error_of("1:2:3:4"), HasSubstr("expected A:B or A:B:STEP"));
  EXPECT_THAT(error_of(""), HasSubstr("expected A:B or A:B:STEP"));
}

TEST(FrameStream, GivesFramesAndReasonsInOrder) {
  EXPECT_THAT(indices(Counting(6), ":"), ElementsAre(0, 1, -2, 3, 4, -5));
  EXPECT_THAT(indices(Counting(10), "1:9:3"), ElementsAre(1, 4, 7));
  EXPECT_TRUE(indices(Counting(0), ":").empty());
}

TEST(FrameStream, DecodesOnlyAsFarAheadAsItWasTold) {
  const Counting dataset(100000);
  FrameStream stream(dataset, {}, 3);
  stream.next();
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_LE(dataset.reads, 5U);  // one taken, three in the queue, and one more at most
}

TEST(FrameStream, StopsEarlyWithoutHanging) {
  const Counting dataset(1000000);
  for (int taken = 0; taken < 50; ++taken) {
    FrameStream stream(dataset, {}, 2);
    for (int i = 0; i < taken; ++i) stream.next();
  }
  EXPECT_LE(dataset.reads, 50U * 54U);
}

TEST(FrameStream, PassesOnWhatTheDatasetThrows) {
  const Counting dataset(10, 2);
  FrameStream stream(dataset);
  EXPECT_TRUE(stream.next());
  EXPECT_TRUE(stream.next());
  EXPECT_THROW(stream.next(), Error);
  EXPECT_FALSE(stream.next());
}

TEST(FrameIterator, VisitsTheUsableFrames) {
  const Counting dataset(8);
  std::vector<std::int64_t> seen;
  for (const Frame& frame : dataset) seen.push_back(frame.index);
  EXPECT_THAT(seen, ElementsAre(0, 1, 3, 4, 6, 7));
}

}  // namespace
}  // namespace panoptic::test
