// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The look at a recording before it is mapped: a room with one wrong number each, and what is said of it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "panoptic/io/doctor.h"
#include "tests/io/box_room.h"
#include "tests/shared_data.h"

namespace panoptic::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const Check& check_named(const DoctorReport& report, const std::string& name) {
  for (const Check& check : report.checks) {
    if (check.name == name) return check;
  }
  throw std::out_of_range(name);
}

DoctorReport preflight(const Dataset& dataset) { return diagnose(dataset, kPreflight); }

// This check is the only one that fails or refuses.
void expect_only(const DoctorReport& report, const std::string& name, Verdict verdict, const std::string& text) {
  for (const Check& check : report.checks) {
    EXPECT_EQ(check.verdict >= Verdict::kFailed, check.name == name) << to_text(report);
  }
  EXPECT_EQ(check_named(report, name).verdict, verdict) << to_text(report);
  EXPECT_THAT(check_named(report, name).evidence + " | " + check_named(report, name).remedy, HasSubstr(text));
}

TEST(Preflight, HasNothingToSayOfARightRecording) {
  EXPECT_LE(preflight(walk_through_a_room()).worst(), Verdict::kOk) << to_text(preflight(walk_through_a_room()));
  EXPECT_LT(preflight(turn_in_a_room()).worst(), Verdict::kFailed) << to_text(preflight(turn_in_a_room()));
}

TEST(Preflight, HasNothingToSayOfRealRecordings) {
  for (const char* name : {"kitchen", "hololens"}) {
    PANOPTIC_REQUIRE_SHARED(std::filesystem::path("data") / name);
    const DoctorReport report = preflight(*open_recording(shared_folder() / "data" / name));
    EXPECT_LE(report.worst(), Verdict::kAssumed) << name << "\n" << to_text(report);
  }
}

TEST(Preflight, RefusesIntrinsicsThatAreNotInPixels) {
  BoxRoom shares = walk_through_a_room();
  shares.camera = {160, 120, 0.9, 1.2, 0.5, 0.5};
  EXPECT_EQ(check_named(preflight(shares), "depth intrinsics").verdict, Verdict::kImpossible);
  EXPECT_THAT(check_named(preflight(shares), "depth intrinsics").evidence,
              HasSubstr("fx = 0.9, fy = 1.2 pixels for images 160x120"));
  EXPECT_THAT(check_named(preflight(shares), "depth intrinsics").remedy,
              HasSubstr("intrinsics are in pixels: multiply fx and cx by 160"));
  BoxRoom millimetres = walk_through_a_room();
  millimetres.camera.fx = millimetres.camera.fy = 3.67;
  EXPECT_EQ(check_named(preflight(millimetres), "depth intrinsics").verdict, Verdict::kImpossible);
  EXPECT_THAT(check_named(preflight(millimetres), "depth intrinsics").remedy, HasSubstr("millimetres"));
}

TEST(Preflight, RefusesAPrincipalPointOutsideTheImageAndNamesTheFactor) {
  BoxRoom room = walk_through_a_room();
  room.camera = {160, 120, 1050, 1050, 599.5, 449.5};  // of 1200x900 images
  const Check check = check_named(preflight(room), "depth intrinsics");
  EXPECT_EQ(check.verdict, Verdict::kImpossible);
  EXPECT_THAT(check.evidence, HasSubstr("principal point 599.5, 449.5 in 160x120 images"));
  EXPECT_THAT(check.remedy, HasSubstr("about 1199x899"));
  EXPECT_THAT(check.remedy, HasSubstr("times 0.133"));
}

TEST(Preflight, NamesTheScaleToWrite) {
  BoxRoom room = walk_through_a_room();
  room.depth_factor = 5;
  room.told_notes.depth_scale = 1000;
  expect_only(preflight(room), "depth scale", Verdict::kFailed, "write [depth] scale = 5000 in the calibration file, not 1000");
}

TEST(Preflight, NamesTheUsualScaleWhereAnotherFitsAsWell) {
  BoxRoom room = walk_through_a_room();
  room.depth_factor = 0.2;
  room.camera.fx = room.camera.fy = 120;  // the true ones are 140: 4 fits as well as 5
  room.told_notes.depth_scale = 5000;
  const Check check = check_named(preflight(room), "depth scale");
  EXPECT_THAT(check.evidence, HasSubstr("depth times 4")) << check.evidence;
  EXPECT_THAT(check.remedy, HasSubstr("write [depth] scale = 1000 in the calibration file, not 5000")) << check.evidence;
}

TEST(Preflight, NamesTheBinaryScaleBesideTheQuarter) {
  BoxRoom room = walk_through_a_room();
  room.depth_factor = 0.256;
  room.told_notes.depth_scale = 1000;
  EXPECT_THAT(check_named(preflight(room), "depth scale").remedy, HasSubstr("(usually 256 instead of 1000)"));
}

TEST(Preflight, RefusesDepthThatNoCameraMeasures) {
  BoxRoom room = walk_through_a_room();
  room.depth_factor = 0.001;
  EXPECT_EQ(check_named(preflight(room), "depth scale").verdict, Verdict::kImpossible);
  EXPECT_THAT(check_named(preflight(room), "depth scale").remedy, HasSubstr("1 instead of 1000"));
}

TEST(Preflight, TellsTranslationsInMillimetresFromAWrongDepthScale) {
  BoxRoom room = walk_through_a_room();
  for (Pose& pose : room.told) pose.translation() *= 1000;
  const DoctorReport report = preflight(room);
  EXPECT_EQ(check_named(report, "poses").verdict, Verdict::kFailed) << to_text(report);
  EXPECT_THAT(check_named(report, "poses").remedy, HasSubstr("millimetres"));
  EXPECT_EQ(check_named(report, "depth scale").verdict, Verdict::kOk) << to_text(report);
}

TEST(Preflight, LearnsNoScaleFromACameraThatOnlyTurns) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.06);
  BoxRoom room = turn_in_a_room();
  for (Pose& pose : room.told) pose.translation() += Vec3d(noise(random), noise(random), noise(random));
  const DoctorReport report = preflight(room);
  EXPECT_EQ(check_named(report, "depth scale").verdict, Verdict::kOk) << to_text(report);
  EXPECT_THAT(to_text(report), Not(HasSubstr("1000")));
}

TEST(Preflight, FindsInverseAndTurnedPoses) {
  BoxRoom inverse = walk_through_a_room();
  for (Pose& pose : inverse.told) pose = pose.inverse();
  expect_only(preflight(inverse), "poses", Verdict::kFailed, "inverse (camera from world)");
  BoxRoom opengl = walk_through_a_room();
  for (Pose& pose : opengl.told) pose.linear() = pose.linear() * Vec3d(1, -1, -1).asDiagonal();
  expect_only(preflight(opengl), "poses", Verdict::kFailed, "y and z flipped (OpenGL camera axes)");
}

TEST(Preflight, FindsQuaternionsWithWAtTheOtherEnd) {
  const auto told = [](const auto& reorder) {
    BoxRoom room = walk_through_a_room();
    for (Pose& pose : room.told) pose.linear() = reorder(Eigen::Quaterniond(pose.linear())).toRotationMatrix();
    return preflight(room);
  };
  using Q = Eigen::Quaterniond;  // w x y z
  expect_only(told([](const Q& q) { return Q(q.z(), q.w(), q.x(), q.y()); }), "poses", Verdict::kFailed, "qw qx qy qz");
  expect_only(told([](const Q& q) { return Q(q.x(), q.y(), q.z(), q.w()); }), "poses", Verdict::kFailed, "qx qy qz qw");
}

TEST(Preflight, FindsDepthAlongTheRays) {
  BoxRoom room = walk_through_a_room();
  room.camera = {160, 120, 140, 140, 79.5, 59.5};
  room.spoil = [camera = room.camera](Image<float>& depth) {
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) depth(u, v) *= static_cast<float>(back_project(camera, u, v, 1).norm());
    }
  };
  expect_only(preflight(room), "depth scale", Verdict::kFailed, "the distance from the camera's centre");
}

TEST(Preflight, NamesTheOrderOfFourIntrinsics) {
  BoxRoom room = walk_through_a_room();
  room.camera = {160, 120, 79.5, 59.5, 140, 140};
  EXPECT_THAT(check_named(preflight(room), "depth intrinsics").remedy, HasSubstr("the numbers look like cx cy fx fy"));
  room.camera = {160, 120, 140, 79.5, 140, 59.5};
  EXPECT_THAT(check_named(preflight(room), "depth intrinsics").remedy, HasSubstr("the numbers look like fx cx fy cy"));
}

TEST(Preflight, FindsPosesThatAreAllTheSame) {
  BoxRoom room = walk_through_a_room();
  for (Pose& pose : room.told) pose = room.way.front();
  expect_only(preflight(room), "poses", Verdict::kFailed, "all poses are the same, and the images are not");
}

TEST(Preflight, LetsACameraStandStill) {
  BoxRoom room = walk_through_a_room();
  for (Pose& pose : room.way) pose = room.way.front();
  room.told = room.way;
  EXPECT_LT(preflight(room).worst(), Verdict::kFailed) << to_text(preflight(room));
}

TEST(Preflight, FindsPosesThatAreShiftedByOne) {
  BoxRoom room = walk_through_a_room(20);
  for (std::size_t i = 0; i < room.way.size(); i += 3) {  // even motion would look the same a frame later
    room.way[i].linear() = Eigen::AngleAxisd(0.15, Vec3d::UnitZ()) * room.way[i].linear();
  }
  room.told = room.way;
  for (std::size_t i = 1; i < room.told.size(); ++i) room.told[i] = room.way[i - 1];
  expect_only(preflight(room), "poses", Verdict::kFailed, "each image with the pose of the one after");
}

TEST(Preflight, NamesAValueThatManyReadingsShare) {
  BoxRoom room = walk_through_a_room();
  room.told_notes.depth_scale = 1000;
  room.spoil = [](Image<float>& depth) {
    for (std::size_t i = 0; i < depth.size(); i += 6) depth[i] = 8;
  };
  const DoctorReport report = preflight(room);
  EXPECT_EQ(check_named(report, "depth readings").verdict, Verdict::kFailed) << to_text(report);
  EXPECT_THAT(check_named(report, "depth readings").evidence, HasSubstr("17 % of all readings are exactly 8 m"));
  EXPECT_THAT(check_named(report, "depth readings").remedy, HasSubstr("invalid = [8000]"));
}

TEST(Preflight, TellsWhatWasAssumed) {
  BoxRoom room = walk_through_a_room();
  room.told_notes = {{"a focal length"}, {"depth/: 3 files *.npy"}, 0};
  const DoctorReport report = preflight(room);
  EXPECT_EQ(check_named(report, "recording").evidence, "a focal length");
  EXPECT_EQ(check_named(report, "left out").evidence, "depth/: 3 files *.npy");
  EXPECT_EQ(report.worst(), Verdict::kAssumed);
}

TEST(Doctor, FindsTheOneJumpInALongRecording) {
  BoxRoom room = walk_through_a_room(2000);
  for (std::size_t i = 1234; i < room.told.size(); ++i) room.told[i].translation() += Vec3d(2, 0, 0);
  const DoctorReport report = diagnose(room, {.frames = 4, .pairs = 4});
  EXPECT_EQ(check_named(report, "steps").verdict, Verdict::kWarning) << to_text(report);
  EXPECT_THAT(check_named(report, "steps").evidence, HasSubstr("from position 1233 to the next; 1 such jump"));
}

TEST(Doctor, ListsAllExplanationsThatFitEqually) {
  BoxRoom room = walk_through_a_room();
  for (std::size_t i = 0; i < room.way.size(); ++i) {  // straight ahead: which of its sides is up cannot be told
    room.way[i] = room.way.front();
    room.way[i].translation() += 0.02 * static_cast<double>(i) * room.way.front().linear().col(2);
  }
  room.told = room.way;
  for (Pose& pose : room.told) pose.linear() = pose.linear() * Vec3d(1, -1, -1).asDiagonal();
  const DoctorReport report = diagnose(room, {.frames = 10, .pairs = 8});
  EXPECT_EQ(check_named(report, "poses").verdict, Verdict::kFailed) << to_text(report);
  EXPECT_THAT(check_named(report, "poses").evidence,
              testing::ContainsRegex("with poses .*; as well with poses .*, or with poses"));
}

TEST(Doctor, WritesWhatItFoundAsJson) {
  const Json json = to_json(DoctorReport{{{"poses", Verdict::kFailed, "27 % agree", "turn them round"}}});
  EXPECT_EQ(json["checks"][0]["name"], "poses");
  EXPECT_EQ(json["checks"][0]["verdict"], "failed");
  EXPECT_EQ(json["checks"][0]["evidence"], "27 % agree");
  EXPECT_EQ(json["checks"][0]["remedy"], "turn them round");
}

}  // namespace
}  // namespace panoptic::test
