// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/profile.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <thread>
#include <vector>

namespace panoptic {
namespace {

// The smallest sample that a share p of all samples does not exceed.
double percentile_by_sorting(std::vector<double> samples, double p) {
  std::sort(samples.begin(), samples.end());
  const auto rank = static_cast<std::size_t>(std::ceil(p * static_cast<double>(samples.size()) - 1e-6));
  return samples[std::max<std::size_t>(rank, 1) - 1];
}

TEST(DurationHistogram, PercentilesAreWithinOnePercentOfSorting) {
  std::mt19937 random(5);
  for (const double spread : {0.01, 1.0, 4.0}) {
    std::lognormal_distribution<double> durations_s(std::log(0.004), spread);
    DurationHistogram histogram;
    std::vector<double> samples;
    for (int i = 0; i < 2000; ++i) {
      samples.push_back(std::clamp(durations_s(random), 1e-6, 1000.0));
      histogram.add(samples.back());
    }
    for (const double p : {0.01, 0.07, 0.25, 0.5, 0.9, 0.95, 0.99, 1.0}) {
      const double expected_ms = percentile_by_sorting(samples, p) * 1e3;
      EXPECT_NEAR(histogram.percentile_ms(p), expected_ms, 0.0101 * expected_ms) << p << " at spread " << spread;
    }
  }
}

TEST(DurationHistogram, CountMeanMaximumAndTotalAreExact) {
  DurationHistogram histogram;
  for (const double seconds : {0.001, 0.002, 0.006}) histogram.add(seconds);
  EXPECT_EQ(histogram.count(), 3U);
  EXPECT_DOUBLE_EQ(histogram.mean_ms(), 3);
  EXPECT_DOUBLE_EQ(histogram.max_ms(), 6);
  EXPECT_DOUBLE_EQ(histogram.total_s(), 0.009);
}

TEST(DurationHistogram, IsZeroWithoutSamples) {
  const DurationHistogram histogram;
  EXPECT_EQ(histogram.count(), 0U);
  EXPECT_EQ(histogram.mean_ms(), 0);
  EXPECT_EQ(histogram.max_ms(), 0);
  EXPECT_EQ(histogram.percentile_ms(0.5), 0);
}

TEST(DurationHistogram, TakesDurationsOutsideItsRange) {
  DurationHistogram histogram;
  histogram.add(0);
  histogram.add(-1e-9);  // a clock that stepped back
  histogram.add(1e7);
  EXPECT_EQ(histogram.count(), 3U);
  EXPECT_LE(histogram.percentile_ms(0.5), 0.00102);
  EXPECT_GT(histogram.percentile_ms(1), 1e6);
}

TEST(DurationHistogram, NeverExceedsTheMaximum) {
  DurationHistogram histogram;
  histogram.add(0.0100001);
  EXPECT_LE(histogram.percentile_ms(0.99), histogram.max_ms());
}

TEST(Profile, KeepsStagesApart) {
  Profile profile;
  profile.add("track", 0.001);
  profile.add("integrate", 0.004);
  profile.add("track", 0.003);
  ASSERT_EQ(profile.stages().size(), 2U);
  EXPECT_EQ(profile.stages().at("track").count(), 2U);
  EXPECT_DOUBLE_EQ(profile.stages().at("integrate").mean_ms(), 4);
}

TEST(Profile, AMillionSamplesTakeNoMoreMemoryThanOne) {
  Profile profile;
  for (int i = 0; i < 1000; ++i) profile.add("stage", 1e-3);
  const double before_mb = peak_rss_mb();
  for (int i = 0; i < 1000000; ++i) profile.add("stage", 1e-6 * i);
  EXPECT_LT(peak_rss_mb() - before_mb, 1.0);
  EXPECT_EQ(profile.stages().at("stage").count(), 1001000U);
}

TEST(Stopwatch, MeasuresElapsedTime) {
  const Stopwatch watch;
  std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_GE(watch.seconds(), 0.005);
}

TEST(PeakRss, CountsMemoryThatWasTouched) {
  const double before_mb = peak_rss_mb();
  std::vector<char> block(200'000'000, 1);
  EXPECT_GT(peak_rss_mb(), std::max(before_mb, 200.0));
  EXPECT_EQ(std::accumulate(block.begin(), block.end(), 0), 200'000'000);
}

}  // namespace
}  // namespace panoptic
