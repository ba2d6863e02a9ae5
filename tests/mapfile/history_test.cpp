// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panoptic/base/sqlite.h"
#include "panoptic/map_file.h"
#include "panoptic/mapfile/map_writer.h"
#include "panoptic/mapfile/presence_notes.h"
#include "panoptic/mapfile/run_notes.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/places.h"

namespace panoptic {
namespace {

using test::error_of;
using test::fresh_folder;
using testing::HasSubstr;

constexpr ClassId kChair{2};
constexpr ClassId kPerson{3};

LabelSet labels() {
  return {"test",
          {{ClassId{1}, "wall", false, {}}, {kChair, "chair", true, {}}, {kPerson, "person", true, {}, 2.5, false, true}}};
}

// One object, which object 4 is now, and one that is gone.
PanopticMap map_with_history() {
  PanopticMap map(MapOptions{}, labels());
  map.voxels.block(map.voxels.allocate({1, 2, 3})).set(5, {.distance = 0.01F, .weight = 2, .label = 6});
  for (int i = 0; i < 3; ++i) map.objects.create(i);
  const ExtentBox box{.min_m = {1, 2, 3}, .max_m = {4, 5, 6}, .center_m = {2, 3, 4}};
  map.history.past = {{PanopticId{4}, kChair, 0.75, 7, 90, 12, 120, box, 333, PanopticId{6}},
                      {PanopticId{5}, kChair, 1, 8, 91, 13, 121, box, 334, PanopticId::kUnknown}};
  map.history.arrivals = {{PanopticId{6}, {PanopticId{4}, 0.875}}};
  return map;
}

SavedState some_state() {
  SavedState state;
  MovingTrack track{3, kPerson, {{10, 0.5, {0, 1, 2}, {3, 4, 5}}, {11, 0.6, {0, 1, 2}, {3, 4, 6}}}};
  state.moving = {{{track, {{kPerson, 2}}}, {{7, ClassId::kUnknown, {{12, 0.7, {0, 0, 0}, {1, 1, 1}}}}, {}}}, 8, 5};
  state.presence.lost[PanopticId{6}] = {{{{-1, 2, 3}, 0xF0}, {{4, 5, 6}, 1}}, 77, 3};
  state.presence.came_up = {{{-7, 8, 9}, 30}, {{1, 1, 1}, -4}};
  state.presence.stays = {{{-7, 8, 9}, {30, 40}}, {{1, 1, 1}, {5, 5}}};
  return state;
}

std::filesystem::path saved() {
  const auto path = fresh_folder() / "map.panoptic";
  const PanopticMap map = map_with_history();
  MapUpdate update = whole_map(map);
  update.notes = notes_of(some_state());
  save_map(path, MapHeader{MapOptions{}, labels()}, update);
  return path;
}

void expect_history(const SavedMap& saved) {
  const ObjectHistory expected = map_with_history().history;
  ASSERT_EQ(saved.map.history.past.size(), 2U);
  for (std::size_t n = 0; n < 2; ++n) {
    const PastObject& a = saved.map.history.past[n];
    const PastObject& b = expected.past[n];
    EXPECT_EQ(std::tuple(a.id, a.class_id, a.probability, a.first_frame, a.last_frame, a.observations, a.gone_frame, a.voxels,
                         a.moved_to),
              std::tuple(b.id, b.class_id, b.probability, b.first_frame, b.last_frame, b.observations, b.gone_frame, b.voxels,
                         b.moved_to));
    EXPECT_EQ(a.box.min_m, b.box.min_m);
    EXPECT_EQ(a.box.max_m, b.box.max_m);
    EXPECT_EQ(a.box.center_m, b.box.center_m);
  }
  ASSERT_EQ(saved.map.history.arrivals.size(), 1U);
  EXPECT_EQ(saved.map.history.arrivals.at(PanopticId{6}).moved_from, PanopticId{4});
  EXPECT_EQ(saved.map.history.arrivals.at(PanopticId{6}).confidence, 0.875);
}

TEST(History, OfObjectsIsLoadedAsItWasSaved) {
  const SavedMap loaded = load_map(saved());
  expect_history(loaded);
  EXPECT_TRUE(loaded.map.labels.is_mobile(kPerson));
  EXPECT_FALSE(loaded.map.labels.is_mobile(kChair));
}

TEST(History, OfWhatMovesIsLoadedAsItWasSaved) {
  const SavedState before = some_state();
  const SavedState after = saved_state(load_map(saved()));
  ASSERT_EQ(after.moving.followed.size(), 2U);
  for (std::size_t n = 0; n < 2; ++n) {
    EXPECT_EQ(after.moving.followed[n].track, before.moving.followed[n].track);
    EXPECT_EQ(after.moving.followed[n].named, before.moving.followed[n].named);
  }
  EXPECT_EQ(std::pair(after.moving.next_id, after.moving.forgotten), std::pair(8U, std::uint64_t{5}));
  EXPECT_EQ(after.presence.came_up, before.presence.came_up);
  EXPECT_EQ(after.presence.stays, before.presence.stays);
  ASSERT_EQ(after.presence.lost.size(), 1U);
  const LostSurface& lost = after.presence.lost.at(PanopticId{6});
  EXPECT_EQ(lost.voxels, before.presence.lost.at(PanopticId{6}).voxels);
  EXPECT_EQ(std::pair(lost.frame, lost.looked_at), std::pair(std::int64_t{77}, std::uint64_t{3}));
}

TEST(History, NotesThatAreCutOrLieAreRefused) {
  const Bytes moving = moving_bytes(some_state().moving);
  const Bytes presence = presence_bytes(some_state().presence);
  const auto head = [](const Bytes& all, std::size_t n) {
    return Bytes(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(n));
  };
  EXPECT_TRUE(moving_from(moving) && presence_from(presence));
  // A head may end between two entries of the last list.
  for (std::size_t n = 0; n < moving.size(); ++n) {
    const auto state = moving_from(head(moving, n));
    EXPECT_TRUE(!state || state->followed.size() < 2) << n;
  }
  for (std::size_t n = 0; n < presence.size(); ++n) {
    const auto state = presence_from(head(presence, n));
    EXPECT_TRUE(!state || state->stays.size() < 2) << n;
  }
  Bytes lie = presence;
  lie[0] = lie[1] = lie[2] = lie[3] = 0xFF;  // four thousand million objects
  EXPECT_FALSE(presence_from(lie));
}

TEST(History, RowsThatCannotBeAreRefused) {
  for (const char* change : {"UPDATE past_objects SET id = 1", "UPDATE past_objects SET min_x_m = 9e999",
                             "UPDATE past_objects SET moved_to = -1", "UPDATE arrivals SET moved_from = -1"}) {
    const auto path = saved();
    Database(path, DatabaseAccess::kWrite).execute(change);
    EXPECT_THAT(error_of([&] { load_map(path); }), HasSubstr("use another copy")) << change;
  }
}

// The view that any SQLite program can ask.
TEST(History, IsAViewOfTheFile) {
  const auto path = saved();
  Database database(path, DatabaseAccess::kRead);
  Statement rows(database,
                 "SELECT id, class, state, moved_from, moved_to, gone_frame FROM object_history WHERE state != 'present'");
  ASSERT_TRUE(rows.step());
  EXPECT_EQ(rows.integer(0), 4);
  EXPECT_EQ(rows.text(1), "chair");
  EXPECT_EQ(rows.text(2), "moved");
  EXPECT_EQ(rows.integer(4), 6);
  EXPECT_EQ(rows.integer(5), 120);
  ASSERT_TRUE(rows.step());
  EXPECT_EQ(rows.text(2), "gone");
  EXPECT_FALSE(rows.step());
}

// A map without copies of its frames, with what this test saves.
TEST(MapFormat, FiveStillLoads) {
  const std::filesystem::path path = test::source_folder() / "tests/golden/format_5.panoptic";
  const SavedMap golden = load_map(path);
  EXPECT_EQ(golden.format, 5);
  EXPECT_THAT(note_of_format(golden, path), testing::AllOf(testing::HasSubstr("has format 5, which lacks copies of its frames"),
                                                           testing::Not(testing::HasSubstr("what moved"))));
  expect_history(golden);
  EXPECT_EQ(saved_state(golden).moving.followed.size(), 2U);
}

}  // namespace
}  // namespace panoptic
