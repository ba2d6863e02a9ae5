// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/eval/panoptic_quality.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "panoptic/eval/benchmark_classes.h"
#include "tests/eval/random_scenes.h"
#include "tests/expect_error.h"

namespace panoptic {
namespace {

constexpr ClassId kWall{1};
constexpr ClassId kChair{5};
constexpr ClassId kTable{7};
constexpr std::size_t kWallIndex = 0;
constexpr std::size_t kChairIndex = 4;
constexpr std::size_t kTableIndex = 6;

// COCO's rules over label images, counted anew for every pair. Labels are 0 = void, else 1 + index into the segments.
void naive_add(const PqSegments& truth, const PqSegments& prediction, std::vector<PqCounts>& counts) {
  const auto area = [&](long t, long p) {  // -1 = any
    double n = 0;
    for (std::size_t v = 0; v < truth.segment_at.size(); ++v) {
      n += (t < 0 || truth.segment_at[v] == t) && (p < 0 || prediction.segment_at[v] == p) ? 1 : 0;
    }
    return n;
  };
  std::set<long> found;
  std::set<long> used;
  const auto truths = static_cast<long>(truth.segments.size());
  const auto predictions = static_cast<long>(prediction.segments.size());
  for (long t = 1; t <= truths; ++t) {
    for (long p = 1; p <= predictions; ++p) {
      const PqSegment& segment = truth.segments[static_cast<std::size_t>(t - 1)];
      if (segment.is_crowd || segment.category != prediction.segments[static_cast<std::size_t>(p - 1)].category) continue;
      const double both = area(t, p);
      const double iou = both / (area(t, -1) + area(-1, p) - both - area(0, p));
      if (iou > 0.5) {
        found.insert(t);
        used.insert(p);
        counts[segment.category].tp++;
        counts[segment.category].iou_sum += iou;
      }
    }
  }
  std::map<std::size_t, long> crowd;
  for (long t = 1; t <= truths; ++t) {
    const PqSegment& segment = truth.segments[static_cast<std::size_t>(t - 1)];
    if (segment.is_crowd) {
      crowd[segment.category] = t;
    } else if (!found.contains(t)) {
      counts[segment.category].fn++;
    }
  }
  for (long p = 1; p <= predictions; ++p) {
    const std::size_t category = prediction.segments[static_cast<std::size_t>(p - 1)].category;
    if (used.contains(p)) continue;
    const double forgiven = area(0, p) + (crowd.contains(category) ? area(crowd[category], p) : 0);
    if (forgiven / area(-1, p) > 0.5) continue;
    counts[category].fp++;
  }
}

// Segments of a scene by the switches of a variant, written with ids as text would have them.
PqSegments naive_segments(const VertexLabels& labels, bool merge_stuff, std::size_t min_thing) {
  std::map<long, std::size_t> size;
  std::vector<long> id_at;
  for (std::size_t v = 0; v < labels.class_id.size(); ++v) {
    const long class_id = number(labels.class_id[v]);
    long id = benchmark_index(labels.class_id[v]) ? class_id * 1000 + static_cast<long>(labels.instance[v]) : 0;
    if (merge_stuff && (class_id == 1 || class_id == 2)) id = class_id * 1000;
    id_at.push_back(id);
    size[id]++;
  }
  PqSegments result;
  std::map<long, std::uint32_t> label = {{0, 0}};
  for (const auto& [id, count] : size) {
    const bool is_thing = id / 1000 > 2;
    if (id == 0 || (is_thing && count < min_thing)) continue;
    result.segments.push_back({*benchmark_index(static_cast<ClassId>(id / 1000)), false});
    label[id] = static_cast<std::uint32_t>(result.segments.size());
  }
  for (const long id : id_at) result.segment_at.push_back(label.contains(id) ? label[id] : 0);
  return result;
}

void expect_equal(const std::vector<PqCounts>& expected, std::span<const PqCounts> counts, const std::string& where) {
  for (std::size_t c = 0; c < expected.size(); ++c) {
    EXPECT_EQ(counts[c].tp, expected[c].tp) << where << " category " << c;
    EXPECT_EQ(counts[c].fp, expected[c].fp) << where << " category " << c;
    EXPECT_EQ(counts[c].fn, expected[c].fn) << where << " category " << c;
    EXPECT_DOUBLE_EQ(counts[c].iou_sum, expected[c].iou_sum) << where << " category " << c;
  }
}

TEST(PanopticQuality, EqualsTheNaiveCountForEveryVariant) {
  struct Switches {
    const char* name;
    bool merge_stuff;
    std::size_t min_true;
    std::size_t min_predicted;
  };
  for (const Switches& s :
       {Switches{"pq-scannet20", true, 100, 100}, {"seed", true, 0, 100}, {"ndt", true, 0, 0}, {"coco", false, 0, 0}}) {
    std::mt19937_64 random(21);
    const PqVariant& variant = pq_variant(s.name);
    for (int round = 0; round < 10; ++round) {
      PanopticQuality metric(kBenchmarkClassCount);
      std::vector<PqCounts> expected(kBenchmarkClassCount);
      for (int scene = 0; scene < 3; ++scene) {
        const VertexLabels truth = test::random_labels(random, 1500);
        const VertexLabels prediction = test::disturbed(random, truth);
        metric.add(true_segments(truth, variant), predicted_segments(prediction, variant));
        naive_add(naive_segments(truth, s.merge_stuff, s.min_true), naive_segments(prediction, s.merge_stuff, s.min_predicted),
                  expected);
      }
      expect_equal(expected, metric.counts(), s.name);
    }
  }
}

TEST(PanopticQuality, ForgivesPredictionsOnTheLastCrowdOfTheirCategory) {
  std::mt19937_64 random(4);
  std::uint64_t crowds = 0;
  for (int round = 0; round < 30; ++round) {
    PqSegments truth = naive_segments(test::random_labels(random, 1200), false, 0);
    const PqSegments prediction = naive_segments(test::random_labels(random, 1200), false, 0);
    for (PqSegment& segment : truth.segments) crowds += (segment.is_crowd = test::below(random, 3) == 0) ? 1 : 0;
    PanopticQuality metric(kBenchmarkClassCount);
    std::vector<PqCounts> expected(kBenchmarkClassCount);
    metric.add(truth, prediction);
    naive_add(truth, prediction, expected);
    expect_equal(expected, metric.counts(), "crowd");
  }
  EXPECT_GT(crowds, 30U);
}

PanopticScores scores_of(const VertexLabels& truth, const VertexLabels& prediction, const char* variant = "pq-scannet20") {
  PanopticQuality metric(kBenchmarkClassCount);
  metric.add(true_segments(truth, pq_variant(variant)), predicted_segments(prediction, pq_variant(variant)));
  return panoptic_scores(metric.counts(), pq_variant(variant));
}

VertexLabels uniform(std::size_t count, ClassId class_id, std::uint32_t instance) {
  return {std::vector<ClassId>(count, class_id), std::vector<std::uint32_t>(count, instance)};
}

void append(VertexLabels& labels, const VertexLabels& more) {
  labels.class_id.insert(labels.class_id.end(), more.class_id.begin(), more.class_id.end());
  labels.instance.insert(labels.instance.end(), more.instance.begin(), more.instance.end());
}

TEST(PanopticQuality, CountsACategoryWithFalsePositivesAloneAsZero) {
  VertexLabels truth = uniform(200, kChair, 1);
  append(truth, uniform(200, kWall, 0));
  VertexLabels prediction = uniform(200, kChair, 9);
  append(prediction, uniform(200, kTable, 3));
  const PanopticScores scores = scores_of(truth, prediction);
  EXPECT_EQ(scores.counts[kTableIndex].fp, 1U);
  EXPECT_EQ(scores.things, (PqScores{0.5, 0.5, 0.5}));
  EXPECT_EQ(scores.stuff, (PqScores{0, 0, 0}));
  EXPECT_EQ(scores_of(truth, prediction, "ndt").things, (PqScores{1, 1, 1})) << "ndt leaves classes without truth out";
}

TEST(PanopticQuality, MergesStuffAndLeavesSmallThingsOut) {
  VertexLabels truth = uniform(50, kWall, 1);
  append(truth, uniform(50, kWall, 2));
  append(truth, uniform(99, kChair, 1));
  VertexLabels prediction = uniform(100, kWall, 0);
  append(prediction, uniform(99, kTable, 0));
  const PanopticScores scores = scores_of(truth, prediction);
  EXPECT_EQ(scores.counts[kWallIndex].tp, 1U);
  EXPECT_EQ(scores.counts[kChairIndex].fn, 0U);
  EXPECT_EQ(scores.counts[kTableIndex].fp, 0U);
  EXPECT_EQ(scores.things, PqScores{});
  EXPECT_EQ(scores_of(truth, prediction, "seed").counts[kChairIndex].fn, 1U) << "seed has no filter on the truth";
  EXPECT_EQ(scores_of(truth, prediction, "coco").counts[kWallIndex].fn, 2U) << "coco takes the two walls as two segments";
}

TEST(PanopticQuality, HasNoScoreWhereThereIsNothing) {
  EXPECT_EQ(scores_of({}, {}).all, PqScores{});
  EXPECT_EQ(scores_of(uniform(300, ClassId{40}, 2), uniform(300, ClassId{0}, 0)).all, PqScores{});
}

TEST(PanopticQuality, NamesItsVariants) {
  EXPECT_THAT(test::error_of([] { pq_variant("best"); }), testing::HasSubstr("'best'; there are pq-scannet20, seed, ndt, coco"));
}

}  // namespace
}  // namespace panoptic
