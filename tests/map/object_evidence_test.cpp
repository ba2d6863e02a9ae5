// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

namespace panoptic {
namespace {

constexpr ClassId kChair{5};
constexpr ClassId kTable{7};

struct Vote {
  std::int64_t frame;
  ClassId class_id;
};

std::vector<Vote> random_votes(std::size_t count, std::int64_t frames, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Vote> votes;
  for (std::size_t i = 0; i < count; ++i) {
    const auto frame = static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(frames));
    votes.push_back({frame - frames / 3, random() % 3 == 0 ? kTable : kChair});
  }
  return votes;
}

VoteHistory history_of(const std::vector<Vote>& votes) {
  VoteHistory history;
  for (const Vote& vote : votes) history.add(vote.frame, vote.class_id);
  return history;
}

// By definition: the smallest power of two whose bins are few enough.
std::map<std::int64_t, std::map<ClassId, std::uint64_t>> naive_bins(const std::vector<Vote>& votes, std::int64_t width) {
  std::map<std::int64_t, std::map<ClassId, std::uint64_t>> bins;
  for (const Vote& vote : votes) {
    const std::int64_t remainder = ((vote.frame % width) + width) % width;
    ++bins[vote.frame - remainder][vote.class_id];
  }
  return bins.size() <= VoteHistory::kMostBins ? bins : naive_bins(votes, 2 * width);
}

ObjectView view(std::int64_t frame, float score, std::uint32_t visible_px) {
  return {frame, kChair, score, visible_px, {1, 2, 3, 4}};
}

TEST(VoteHistory, CountsEveryVoteInTheNarrowestBinsThatAreFewEnough) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const auto votes = random_votes(1 + seed * 7, std::int64_t{3} << (seed % 20), seed);
    const VoteHistory history = history_of(votes);
    const auto expected = naive_bins(votes, 1);
    ASSERT_EQ(history.bins().size(), expected.size()) << seed;
    auto at = expected.begin();
    for (const VoteHistory::Bin& bin : history.bins()) {
      EXPECT_EQ(history.first_frame(bin), at->first);
      EXPECT_EQ(bin.votes, at->second);
      ++at;
    }
  }
}

TEST(VoteHistory, TheOrderOfVotesAndOfMergersDoesNotMatter) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    auto votes = random_votes(200, 5000, seed);
    const VoteHistory whole = history_of(votes);
    std::shuffle(votes.begin(), votes.end(), std::mt19937_64(seed));
    EXPECT_EQ(history_of(votes), whole);
    const auto cut = votes.begin() + static_cast<std::ptrdiff_t>(seed * 10);
    VoteHistory a = history_of({votes.begin(), cut});
    VoteHistory b = history_of({cut, votes.end()});
    const VoteHistory first = a;
    a.merge(b);
    b.merge(first);
    EXPECT_EQ(a, whole);
    EXPECT_EQ(b, whole);
  }
}

TEST(VoteHistory, HoldsAnyFrameNumber) {
  VoteHistory history;
  for (int i = 0; i < 20; ++i) history.add(i, kChair);
  history.add(std::numeric_limits<std::int64_t>::max(), kTable);
  history.add(std::numeric_limits<std::int64_t>::min(), kTable);
  std::uint64_t votes = 0;
  for (const VoteHistory::Bin& bin : history.bins()) {
    for (const auto& [class_id, count] : bin.votes) votes += count;
  }
  EXPECT_EQ(votes, 22U);
  EXPECT_LE(history.bins().size(), VoteHistory::kMostBins);
  EXPECT_EQ(history.first_frame(history.bins().front()), std::numeric_limits<std::int64_t>::min());
}

TEST(BestViews, KeepsTheThreeLargestByScoreTimesAreaBestFirst) {
  std::mt19937_64 random(4);
  std::vector<ObjectView> all;
  BestViews best;
  for (int i = 0; i < 200; ++i) {
    all.push_back(view(i, static_cast<float>(random() % 8) / 8, static_cast<std::uint32_t>(random() % 50)));
    const bool wanted = best.wants(all.back());
    const BestViews before = best;
    best.add(all.back());
    EXPECT_EQ(wanted, !(best == before));
  }
  std::stable_sort(all.begin(), all.end(), [](const ObjectView& a, const ObjectView& b) {
    return double{a.score} * a.visible_px > double{b.score} * b.visible_px;  // stable: ties stay with the earlier frame
  });
  ASSERT_EQ(best.views().size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(best.views()[i], all[i]);
}

TEST(BestViews, TiesGoToTheEarlierFrame) {
  BestViews best;
  for (const std::int64_t frame : {40, 30, 20, 10}) best.add(view(frame, 0.5F, 100));
  ASSERT_EQ(best.views().size(), 3U);
  EXPECT_EQ(best.views()[0].frame, 10);
  EXPECT_EQ(best.views()[2].frame, 30);
}

TEST(BestViews, MergingEitherWayKeepsTheBestOfBoth) {
  BestViews a;
  BestViews b;
  for (int i = 0; i < 3; ++i) a.add(view(i, 0.5F, static_cast<std::uint32_t>(10 + i)));
  for (int i = 0; i < 2; ++i) b.add(view(i, 0.5F, static_cast<std::uint32_t>(11 + 10 * i)));
  BestViews ab = a;
  ab.merge(b);
  BestViews ba = b;
  ba.merge(a);
  EXPECT_EQ(ab, ba);
  EXPECT_EQ(ab.views()[0].visible_px, 21U);
  EXPECT_EQ(ab.views()[1].visible_px, 12U);
}

}  // namespace
}  // namespace panoptic
