// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects/moving_tracks.h"

#include <gtest/gtest.h>

namespace panoptic {
namespace {

constexpr ClassId kPerson{31};
constexpr ClassId kDog{42};

MovingThing thing(double x, double y, ClassId class_id = ClassId::kUnknown) {
  return {class_id, {x - 0.2, y - 0.2, 0}, {x + 0.2, y + 0.2, 1.8}, 100};
}

TEST(MovingTracks, FollowTwoWhoPassEachOther) {
  MovingTracks tracks;
  for (int i = 0; i < 60; ++i) {
    const double t = i / 30.0;
    tracks.add(std::vector{thing(t, 0, kPerson), thing(2 - t, 0.8, kPerson)}, i, t, false);
  }
  const std::vector<MovingTrack> found = tracks.tracks();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].boxes.size(), 60U);
  EXPECT_EQ(found[1].boxes.size(), 60U);
  EXPECT_NEAR(found[0].boxes.back().max_m.y(), 0.2, 1e-9);
  EXPECT_NEAR(found[1].boxes.back().max_m.y(), 1.0, 1e-9);
}

TEST(MovingTracks, GoOnAfterAShortGapAndNotAfterALongOne) {
  MovingTracks tracks;
  for (const double t : {0.0, 0.1, 0.2, 1.0, 1.1, 1.2, 4.0, 4.1, 4.2})
    tracks.add(std::vector{thing(t, 0)}, static_cast<int>(10 * t), t, false);
  const std::vector<MovingTrack> found = tracks.tracks();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].boxes.size(), 6U);
  EXPECT_EQ(found[1].boxes.size(), 3U);
}

TEST(MovingTracks, TakeTheClassThatMostFramesSaw) {
  MovingTracks tracks;
  for (int i = 0; i < 9; ++i) tracks.add(std::vector{thing(0, 0, i % 3 == 0 ? kPerson : ClassId::kUnknown)}, i, i / 30.0, false);
  ASSERT_EQ(tracks.tracks().size(), 1U);
  EXPECT_EQ(tracks.tracks()[0].class_id, kPerson);
  EXPECT_EQ(tracks.tracks()[0].boxes.size(), 9U);
  tracks.add(std::vector{thing(0, 0, kDog)}, 9, 0.3, false);
  EXPECT_EQ(tracks.state().followed.size(), 2U) << "a dog is no person";
}

TEST(MovingTracks, ForgetWhatFlashedUp) {
  MovingTracks tracks;
  tracks.add(std::vector{thing(0, 0)}, 0, 0, false);
  tracks.add({}, 60, 2, false);
  EXPECT_TRUE(tracks.state().followed.empty());
  tracks.add(std::vector{thing(5, 0)}, 61, 2.1, false);
  EXPECT_EQ(tracks.state().followed.front().track.id, 2U) << "ids are never given twice";
}

TEST(MovingTracks, ExpectPeopleWhereTheyCanHaveGone) {
  MovingTracks tracks;
  tracks.add(std::vector{thing(0, 0, kPerson), thing(4, 0)}, 0, 0, false);
  const std::vector<MovingThing> expected = tracks.expected(0.5, false);
  ASSERT_EQ(expected.size(), 1U) << "what has no class is known by its motion alone";
  EXPECT_EQ(expected[0].class_id, kPerson);
  EXPECT_NEAR(expected[0].min_m.x(), -1.2, 1e-9);
  EXPECT_TRUE(tracks.expected(1.5, false).empty());
}

TEST(MovingTracks, ExpectWhomANetworkMissesForAWhile) {
  MovingTracks tracks;
  constexpr int kFound = 4;
  int frame = 0;
  for (; frame < kFound; ++frame) tracks.add(std::vector{thing(0, 0, kPerson)}, frame, frame / 30.0, true);
  int misses = 0;
  for (; misses < 100 && !tracks.expected(frame / 30.0, true).empty(); ++misses, ++frame) {
    tracks.add(std::vector{thing(0, 0)}, frame, frame / 30.0, true);  // somebody is there, a network says nothing of it
  }
  EXPECT_EQ(misses, 7 * kFound);
  EXPECT_EQ(tracks.expected(frame / 30.0, false).size(), 1U) << "where no network looks, nobody says that they are gone";
  ASSERT_EQ(tracks.tracks().size(), 1U);
  EXPECT_EQ(tracks.tracks()[0].class_id, kPerson);
}

TEST(MovingTracks, DoNotGrowWhereNoNetworkSawThem) {
  MovingTracks tracks;
  tracks.add(std::vector{thing(0, 0, kPerson)}, 0, 0, true);
  for (int i = 1; i < 20; ++i) {
    MovingThing with_wall = tracks.expected(i / 30.0, false).at(0);
    with_wall.class_id = ClassId::kUnknown;
    with_wall.min_m.x() -= 0.1;
    with_wall.max_m.x() += 0.1;
    tracks.add(std::vector{with_wall}, i, i / 30.0, false);
  }
  const TrackedBox last = tracks.tracks().at(0).boxes.back();
  EXPECT_NEAR(last.max_m.x() - last.min_m.x(), 0.4, 1e-9);
  EXPECT_NEAR(last.max_m.x() + last.min_m.x(), 0, 1e-9);
}

TEST(MovingTracks, HoldSoManyBoxesAndForgetTheOldest) {
  MovingTracks tracks;
  constexpr int kFrames = 30000;
  for (int i = 0; i < kFrames; ++i) {
    std::vector<MovingThing> things;
    for (int n = 0; n < 8; ++n) things.push_back(thing(10 * n + (i > kFrames / 2 ? 5 : 0), 0));
    tracks.add(things, i, i / 30.0, false);
  }
  std::size_t boxes = 0;
  for (const MovingTrack& track : tracks.tracks()) boxes += track.boxes.size();
  EXPECT_LE(boxes, MovingTracks::kMostBoxes);
  EXPECT_EQ(boxes + tracks.state().forgotten, 8U * kFrames);
}

}  // namespace
}  // namespace panoptic
