// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/eval/change_scores.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "panoptic/base/files.h"
#include "tests/eval/random_scenes.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"

namespace panoptic::test {
namespace {

using ::testing::HasSubstr;

Eigen::AlignedBox3d box_at(double x, double y, double size_m = 0.5) {
  return {Vec3d(x, y, 0), Vec3d(x + size_m, y + size_m, 2 * size_m)};
}

PlaceChange gone(const std::string& name, const Eigen::AlignedBox3d& box, bool counts = true) {
  return {name, box, std::nullopt, counts};
}

// Follows the definition: again and again the nearest pair that is left.
ChangeCounts naive_counts(std::vector<PlaceChange> truths, const std::vector<PlaceChange>& claims, bool any_class) {
  const auto fits = [&](const PlaceChange& t, const PlaceChange& c) {
    const Vec3d middle = c.old_box->center();
    const Vec3d outside = (t.old_box->min() - middle).cwiseMax(middle - t.old_box->max()).cwiseMax(0);
    return (any_class || t.class_name == c.class_name) && outside.norm() <= 0.15;
  };
  std::vector<int> truth_of(claims.size(), -1);
  std::vector<bool> taken(truths.size(), false);
  for (;;) {
    double least = std::numeric_limits<double>::infinity();
    std::size_t best_t = 0;
    std::size_t best_c = 0;
    for (std::size_t t = 0; t < truths.size(); ++t) {
      for (std::size_t c = 0; c < claims.size(); ++c) {
        const double apart = (truths[t].old_box->center() - claims[c].old_box->center()).norm();
        if (taken[t] || truth_of[c] >= 0 || !fits(truths[t], claims[c]) || apart >= least) continue;
        least = apart;
        best_t = t;
        best_c = c;
      }
    }
    if (!(least < std::numeric_limits<double>::infinity())) break;
    taken[best_t] = true;
    truth_of[best_c] = static_cast<int>(best_t);
  }
  ChangeCounts counts;
  for (std::size_t t = 0; t < truths.size(); ++t) {
    counts.truths += truths[t].counts ? 1 : 0;
    counts.found += truths[t].counts && taken[t] ? 1 : 0;
  }
  for (std::size_t c = 0; c < claims.size(); ++c) {
    bool is_about = false;
    for (const PlaceChange& truth : truths) is_about = is_about || fits(truth, claims[c]);
    if (truth_of[c] >= 0) {
      (truths[static_cast<std::size_t>(truth_of[c])].counts ? counts.claims : counts.unjudged) += 1;
    } else {
      (is_about ? counts.repeated : counts.claims) += 1;
    }
  }
  return counts;
}

TEST(ChangeScores, AreThoseOfTheDefinitionOnRandomChanges) {
  std::mt19937_64 random(4);
  const char* kNames[] = {"chair", "table"};
  const auto some = [&](std::size_t most) {
    std::vector<PlaceChange> changes;
    for (std::size_t i = below(random, most + 1); i > 0; --i) {
      const double x = 0.2 * static_cast<double>(below(random, 12)) + 1e-3 * static_cast<double>(below(random, 50));
      changes.push_back(
          gone(kNames[below(random, 2)], box_at(x, 0.1 * static_cast<double>(below(random, 9))), below(random, 4) > 0));
    }
    return changes;
  };
  for (int i = 0; i < 300; ++i) {
    const std::vector<PlaceChange> truths = some(6);
    const std::vector<PlaceChange> claims = some(8);
    for (const bool any_class : {false, true}) {
      const ChangeCounts expected = naive_counts(truths, claims, any_class);
      const ChangeCounts actual = count_changes(truths, claims, any_class);
      EXPECT_EQ(actual.truths, expected.truths);
      EXPECT_EQ(actual.found, expected.found) << i;
      EXPECT_EQ(actual.claims, expected.claims) << i;
      EXPECT_EQ(actual.repeated, expected.repeated) << i;
      EXPECT_EQ(actual.unjudged, expected.unjudged) << i;
    }
  }
}

TEST(ChangeScores, AClaimOfAnotherClassIsWrongUnlessClassesDoNotMatter) {
  const ChangeCounts counts = count_changes({gone("table", box_at(0, 0))}, {gone("desk", box_at(0, 0))}, false);
  EXPECT_EQ(counts.found, 0U);
  EXPECT_EQ(counts.precision(), 0);
  EXPECT_EQ(counts.recall(), 0);
  EXPECT_EQ(counts.f1(), 0);
  EXPECT_EQ(count_changes({gone("table", box_at(0, 0))}, {gone("desk", box_at(0, 0))}, true).f1(), 1);
}

TEST(ChangeScores, WhatNobodyCouldSeeIsNeitherMissedNorWronglyClaimed) {
  const ChangeCounts missed = count_changes({gone("chair", box_at(0, 0), false)}, {}, false);
  EXPECT_FALSE(missed.f1());
  const ChangeCounts claimed = count_changes({gone("chair", box_at(0, 0), false)}, {gone("chair", box_at(0, 0))}, false);
  EXPECT_EQ(claimed.unjudged, 1U);
  EXPECT_FALSE(claimed.precision());
}

TEST(ChangeScores, AMovedThingIsRightAtBothPlaces) {
  const PlaceChange truth{"chair", box_at(0, 0), box_at(3, 0)};
  EXPECT_EQ(count_changes({truth}, {{"chair", box_at(0, 0), box_at(3, 0)}}, false).found, 1U);
  EXPECT_EQ(count_changes({truth}, {{"chair", box_at(0, 0), box_at(2, 0)}}, false).found, 0U);
}

TEST(ChangeScores, TrueChangesCountOnlyIfTheirPlacesWereShownForHalfASecond) {
  DynamicsTruth truth;
  TrueChange change;
  change.kind = EventKind::kMoved;
  change.class_name = "couch";
  change.old_box = box_at(0, 0);
  change.new_box = box_at(3, 0);
  change.old_place = {15, 15, 40};
  change.new_place = {15, 14, 40};
  truth.changes = {change};
  const PlaceChanges changes = true_changes(truth);
  ASSERT_EQ(changes.gone.size(), 1U);
  EXPECT_EQ(changes.gone[0].class_name, "sofa");
  EXPECT_TRUE(changes.gone[0].counts);
  EXPECT_FALSE(changes.fresh.at(0).counts);
  EXPECT_FALSE(changes.moved.at(0).counts);
}

constexpr const char* kObjects = R"({"objects": [
  {"id": 50, "class": "chair", "state": "moved", "box": {"min_m": [0, 0, 0], "max_m": [0.5, 0.5, 1]}},
  {"id": 51, "class": "chair", "state": "present", "moved_from": 50, "appeared": true,
   "box": {"min_m": [3, 0, 0], "max_m": [3.5, 0.5, 1]}},
  {"id": 52, "class": "table", "state": "gone", "moved_from": null, "box": {"min_m": [5, 0, 0], "max_m": [6, 1, 0.7]}},
  {"id": 53, "class": "sofa", "state": "present", "moved_from": null, "appeared": false,
   "box": {"min_m": [7, 0, 0], "max_m": [9, 1, 0.8]}}]})";

TEST(ChangeScores, ClaimsAreReadFromTheObjectsOfARun) {
  const std::filesystem::path folder = fresh_folder();
  write_file(folder / "objects.json", std::string_view(kObjects));
  const PlaceChanges claims = claimed_changes(folder);
  ASSERT_EQ(claims.gone.size(), 2U);
  ASSERT_EQ(claims.fresh.size(), 1U);
  ASSERT_EQ(claims.moved.size(), 1U);
  EXPECT_EQ(claims.moved[0].old_box->min(), Vec3d(0, 0, 0));
  EXPECT_EQ(claims.moved[0].new_box->min(), Vec3d(3, 0, 0));
}

TEST(ChangeScores, AClaimIsWhereTheMiddleOfItsSurfaceIs) {
  const std::filesystem::path folder = fresh_folder();
  write_file(folder / "objects.json", std::string_view(R"({"objects": [{"id": 50, "class": "chair", "state": "gone",
    "box": {"min_m": [0, 0, 0], "max_m": [4, 0.5, 1]}, "centroid_m": [0.25, 0.25, 0.5]}]})"));
  EXPECT_EQ(count_changes({gone("chair", box_at(0, 0))}, claimed_changes(folder).gone, false).found, 1U);
}

TEST(ChangeScores, ARunWithoutStatesIsRefused) {
  const std::filesystem::path folder = fresh_folder();
  write_file(folder / "objects.json",
             std::string_view(R"({"objects": [{"id": 5, "class": "chair", "box": {"min_m": [0, 0, 0], "max_m": [1, 1, 1]}}]})"));
  EXPECT_THAT(error_of([&] { claimed_changes(folder); }), HasSubstr("state"));
}

TEST(ChangeScores, GhostsAndCompletenessAreThoseOfTheSurfaceAtFiveCentimetres) {
  SurfaceScores surface;
  surface.at[0] = {0.05, 0.9, 0.8, 0.85};
  const ChangeScores scores = change_scores({}, {}, surface);
  EXPECT_NEAR(*scores.ghost_share, 0.1, 1e-12);
  EXPECT_EQ(scores.completeness, 0.8);
  EXPECT_THAT(to_table(scores), HasSubstr("ghost share 10.0, completeness 80.0"));
  EXPECT_TRUE(to_json(scores)["moved"]["f1"].is_null());
}

}  // namespace
}  // namespace panoptic::test
