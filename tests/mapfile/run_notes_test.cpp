// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapfile/run_notes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/expect_error.h"

namespace panoptic {
namespace {

using test::error_of;
using testing::HasSubstr;

SavedMap with_counters(const std::string& text) {
  const LabelSet labels("one", {{ClassId{1}, "wall", false, {}}});
  SavedMap saved{{}, PanopticMap({}, labels), notes_of({})};
  saved.notes.texts["session"] = text;
  return saved;
}

TEST(RunNotes, CountersSurvive) {
  SavedState state;
  state.label_frames = 5;
  state.labelled = 4;
  state.last_frame = -7;
  state.up_sum = Vec3d(0, -1.5, 0.25);
  const SavedState read = saved_state(with_counters(notes_of(state).texts.at("session")));
  EXPECT_EQ(read.label_frames, 5U);
  EXPECT_EQ(read.labelled, 4U);
  EXPECT_EQ(read.last_frame, -7);
  EXPECT_EQ(read.up_sum, state.up_sum);
}

TEST(RunNotes, RefusesCountersThatAreNoWholeNumbers) {
  for (const char* count : {"1e300", "0.5", "\"5\"", "null", "[5]"}) {
    const std::string text =
        std::string(R"({"label_frames": )") + count + R"(, "labelled": 4, "last_frame": 7, "up_sum": [0, 0, 0]})";
    EXPECT_THAT(error_of([&] { saved_state(with_counters(text)); }), HasSubstr("does not belong to its map")) << count;
  }
}

}  // namespace
}  // namespace panoptic
