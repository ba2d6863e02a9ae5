// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/dynamics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panoptic/base/files.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"

namespace panoptic::test {
namespace {

using ::testing::HasSubstr;

DynamicsTruth some_truth() {
  DynamicsTruth truth;
  truth.dynamics = "busy";
  truth.frames = 100;
  const Eigen::AlignedBox3d old_box(Vec3d(0, 0, 0), Vec3d(0.5, 0.5, 1));
  const Eigen::AlignedBox3d new_box(Vec3d(2, 0, 0), Vec3d(2.5, 0.5, 1));
  TrueThing chair{3, ClassId{5}, "chair", "Oak chair", {}};
  chair.stays.push_back({0, 59, Pose::Identity(), old_box, EventKind::kMoved});
  chair.stays.push_back({60, 99, Pose(Eigen::Translation3d(2, 0, 0)), new_box, std::nullopt});
  truth.things = {chair};
  TrueChange moved;
  moved.frame = 60;
  moved.kind = EventKind::kMoved;
  moved.instance = 3;
  moved.class_name = "chair";
  moved.old_box = old_box;
  moved.new_box = new_box;
  moved.old_place = {20, 15, 70};
  TrueChange gone = moved;
  gone.kind = EventKind::kRemoved;
  gone.new_box.reset();
  truth.changes = {moved, gone};
  truth.movers = {{9, ClassId{31}, "person", {{4, "walking", old_box}}}};
  return truth;
}

TEST(Dynamics, AreReadAsTheyWereWritten) {
  const std::filesystem::path path = fresh_folder() / kDynamicsFile;
  write_dynamics(path, some_truth());
  const DynamicsTruth read = read_dynamics(path);
  EXPECT_EQ(read.dynamics, "busy");
  EXPECT_EQ(read.frames, 100);
  ASSERT_EQ(read.things.size(), 1U);
  ASSERT_EQ(read.things[0].stays.size(), 2U);
  EXPECT_EQ(read.things[0].name, "Oak chair");
  EXPECT_EQ(read.things[0].stays[0].ended_by, EventKind::kMoved);
  EXPECT_FALSE(read.things[0].stays[1].ended_by);
  EXPECT_EQ(read.things[0].stays[1].world_from_object.translation(), Vec3d(2, 0, 0));
  ASSERT_EQ(read.changes.size(), 2U);
  EXPECT_EQ(read.changes[0].new_box->min(), Vec3d(2, 0, 0));
  EXPECT_FALSE(read.changes[1].new_box);
  EXPECT_EQ(read.changes[0].old_place.before, 20);
  EXPECT_EQ(read.changes[0].old_place.first_after, 70);
  EXPECT_FALSE(read.changes[0].new_place.first_after);
  ASSERT_EQ(read.movers.size(), 1U);
  EXPECT_EQ(read.movers[0].frames[0].activity, "walking");
  EXPECT_EQ(read.movers[0].class_name, "person");
}

TEST(Dynamics, WhatIsWrongIsNamed) {
  const std::filesystem::path path = fresh_folder() / kDynamicsFile;
  const auto broken = [&](const std::string& from, const std::string& to) {
    write_dynamics(path, some_truth());
    std::string text = read_file(path);
    const std::size_t at = text.find(from);
    if (at == std::string::npos) {
      ADD_FAILURE() << from;
    } else {
      write_file(path, text.replace(at, from.size(), to));
    }
    return error_of([&] { read_dynamics(path); });
  };
  EXPECT_THAT(broken("panoptic dynamics", "other"), HasSubstr("format"));
  EXPECT_THAT(broken("\"removed\"", "\"eaten\""), HasSubstr("removed, moved, added or door"));
  EXPECT_THAT(broken("\"min_m\"", "\"low\""), HasSubstr("min_m"));
  EXPECT_THAT(error_of([&] { read_dynamics(path.parent_path() / "none.json"); }), HasSubstr("none.json"));
}

TEST(Dynamics, MasksAreNamedByTheirFrame) { EXPECT_EQ(moving_mask_name(12), "000012.png"); }

}  // namespace
}  // namespace panoptic::test
