// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/benchmark/vote_map.h"

#include <gtest/gtest.h>

namespace panoptic {
namespace {

constexpr auto kWall = LabelSlot{1};
constexpr auto kChair = LabelSlot{50};

// One pixel that sees a point 1 m ahead.
struct OnePixel {
  Frame frame;
  RegisteredFrame registered;

  explicit OnePixel(float depth = 1) {
    frame.depth_camera = {.width = 1, .height = 1, .fx = 1, .fy = 1, .cx = 0, .cy = 0};
    registered.width = registered.height = 1;
    registered.depth = {depth, 0};
  }
  void vote(LabelSlot id, VoteMap& votes) const {
    const std::array<LabelSlot, 2> labels{id, LabelSlot::kNoVote};
    votes.add(frame, registered, labels);
  }
};

const Vec3f kThere(0.001F, 0.001F, 1.001F);

TEST(VoteMap, TheLabelWithMostVotesWins) {
  VoteMap votes(0.1F);
  const OnePixel pixel;
  pixel.vote(kWall, votes);
  pixel.vote(kChair, votes);
  pixel.vote(kChair, votes);
  EXPECT_EQ(votes.winner(kThere), kChair);
}

TEST(VoteMap, TheLowerIdWinsATie) {
  VoteMap votes(0.1F);
  const OnePixel pixel;
  pixel.vote(kChair, votes);
  pixel.vote(kWall, votes);
  EXPECT_EQ(votes.winner(kThere), kWall);
}

TEST(VoteMap, AsksTheNeighboursWhereNobodyVoted) {
  VoteMap votes(0.1F);
  OnePixel().vote(kChair, votes);
  EXPECT_EQ(votes.winner(kThere + Vec3f(0.1F, 0, 0)), kChair);
  EXPECT_EQ(votes.winner(kThere + Vec3f(0.25F, 0, 0)), std::nullopt);
}

TEST(VoteMap, PixelsWithoutDepthOrVoteAreSilent) {
  VoteMap votes(0.1F);
  OnePixel(0).vote(kChair, votes);
  OnePixel().vote(LabelSlot::kNoVote, votes);
  EXPECT_EQ(votes.winner(kThere), std::nullopt);
}

}  // namespace
}  // namespace panoptic
