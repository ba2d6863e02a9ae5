// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Several recordings as one: numbers, poses and time stamps of their frames, and what is refused.
#include "panoptic/io/recording_list.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "panoptic/error.h"
#include "panoptic/io/doctor.h"
#include "tests/fresh_folder.h"
#include "tests/io/box_room.h"
#include "tests/io/recordings.h"

namespace panoptic::test {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

class List : public testing::Test {
 protected:
  List() : folder_(fresh_folder("list")) {
    write_seven_scenes(folder_ / "a");
    write_scannet_export(folder_ / "homes" / "b");  // numbered 0, 9, 10, 200
  }

  fs::path write(const std::string& text) const {
    write_text(folder_ / "list.toml", text);
    return folder_ / "list.toml";
  }
  std::string refusal(const std::string& text) const { return error_of(write(text)); }

  static constexpr const char* kTwo = R"([[recording]]
path = "a"
[[recording]]
path = "homes/b"
rotation = [0, -1, 0, 1, 0, 0, 0, 0, 1]
translation = [7, 0, -1]
)";

  fs::path folder_;
};

TEST_F(List, WrittenAndReadAgainIsTheSameWhereverItLies) {
  const std::vector<ListedRecording> before = read_recording_list(write(R"([[recording]]
path = "a \"quoted\" name"
pair_tolerance_s = 0.1
[[recording]]
path = "sim:7"
calibration = "c.toml"
predictions = "p"
rotation = [0, -1, 0, 1, 0, 0, 0, 0, 1]
translation = [7, 0.1, -1e-7]
)"));
  fs::create_directories(folder_ / "elsewhere");
  write_text(folder_ / "elsewhere" / "list.toml", to_toml(before));
  const std::vector<ListedRecording> after = read_recording_list(folder_ / "elsewhere" / "list.toml");
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i) {
    EXPECT_EQ(after[i].recording, before[i].recording);
    EXPECT_EQ(after[i].calibration, before[i].calibration);
    EXPECT_EQ(after[i].pair_tolerance_s, before[i].pair_tolerance_s);
    EXPECT_EQ(after[i].predictions, before[i].predictions);
    EXPECT_EQ(after[i].world_from_recording.matrix(), before[i].world_from_recording.matrix());
  }
}

TEST_F(List, FramesKeepTheirNumbersBehindThoseOfTheRecordingBefore) {
  const auto list = open_recording(write(kTwo));
  ASSERT_EQ(list->size(), 8U);
  const auto a = open_recording(folder_ / "a");
  std::int64_t after_a = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(list->read(i).frame->index, a->read(i).frame->index);
    after_a = a->read(i).frame->index + 1;
  }
  constexpr std::array kOfB = {0, 9, 10, 200};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(list->read(4 + i).frame->index, after_a + kOfB[i]);
}

TEST_F(List, PosesAreMovedAndImagesAreNot) {
  const auto list = open_recording(write(kTwo));
  const auto b = open_recording(folder_ / "homes" / "b");
  Pose world_from_b = Pose::Identity();
  world_from_b.linear() << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  world_from_b.translation() = Vec3d(7, 0, -1);
  for (std::size_t i = 0; i < 4; ++i) {
    const Frame own = *b->read(i).frame;
    const Frame moved = *list->read(4 + i).frame;
    EXPECT_TRUE(moved.world_from_camera.isApprox(world_from_b * own.world_from_camera, 1e-12));
    EXPECT_TRUE(list->pose(4 + i)->isApprox(moved.world_from_camera, 1e-12));
    EXPECT_EQ(moved.depth_camera, own.depth_camera);
    EXPECT_EQ(moved.depth.copied(), own.depth.copied());
    EXPECT_EQ(moved.color.copied(), own.color.copied());
  }
}

TEST_F(List, TheFirstRecordingIsAsItWouldBeAlone) {
  const auto list = open_recording(write(kTwo));
  const auto a = open_recording(folder_ / "a");
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(list->read(i).frame->world_from_camera.matrix(), a->read(i).frame->world_from_camera.matrix())
        << "not a bit differs";
    EXPECT_EQ(list->read(i).frame->time_s, a->read(i).frame->time_s);
  }
}

TEST_F(List, TimeStampsNeverGoBack) {
  const auto list = open_recording(write(kTwo));
  for (std::size_t i = 1; i < list->size(); ++i) EXPECT_GT(list->read(i).frame->time_s, list->read(i - 1).frame->time_s);
  EXPECT_NEAR(list->read(4).frame->time_s - list->read(3).frame->time_s, 2, 1e-9);
}

TEST_F(List, EachRecordingHasItsOwnCalibration) {
  write_text(folder_ / "c.toml", "[depth]\nscale = 500\n");
  const auto list = open_recording(write("[[recording]]\npath = \"a\"\n[[recording]]\npath = \"a\"\ncalibration = \"c.toml\"\n"));
  EXPECT_FLOAT_EQ(list->read(4).frame->depth(5, 5), 2 * list->read(0).frame->depth(5, 5));
}

TEST_F(List, AFrameThatCannotBeReadKeepsItsNumberAndReason) {
  fs::remove(folder_ / "homes" / "b" / "pose" / "9.txt");
  const ReadResult read = open_recording(write(kTwo))->read(5);
  ASSERT_FALSE(read.frame);
  EXPECT_EQ(read.skipped.index, open_recording(folder_ / "a")->read(3).frame->index + 1 + 9);
  EXPECT_EQ(read.skipped.reason, open_recording(folder_ / "homes" / "b")->read(1).skipped.reason);
}

TEST_F(List, NotesNameTheRecording) {
  const RecordingNotes own = open_recording(folder_ / "a")->notes();
  ASSERT_FALSE(own.assumed.empty());
  EXPECT_THAT(open_recording(write(kTwo))->notes().assumed, testing::Contains("a: " + own.assumed.front()));
}

TEST_F(List, WhatIsWrongIsRefusedWithTheFileAndTheEntry) {
  const auto with = [](const std::string& line) { return "[[recording]]\npath = \"a\"\n" + line + "\n"; };
  EXPECT_THAT(refusal(with("translation = [nan, 0, 0]")), HasSubstr("list.toml"));
  EXPECT_THAT(refusal(with("translation = [nan, 0, 0]")), HasSubstr("translation"));
  EXPECT_THAT(refusal(with("translation = [inf, 0, 0]")), HasSubstr("translation"));
  EXPECT_THAT(refusal(with("translation = [20000, 0, 0]")), HasSubstr("translation"));
  EXPECT_THAT(refusal(with("translation = [1, 2]")), HasSubstr("list.toml: a: translation has 2 numbers, expected 3"));
  EXPECT_THAT(refusal(with("rotation = [1, 0, 0, 0, 1, 0, 0, 0, -1]")), HasSubstr("list.toml: a: rotation is not a rotation"));
  EXPECT_THAT(refusal(with("rotation = [1, 0, 0]")), HasSubstr("rotation has 3 numbers"));
  EXPECT_THAT(refusal(with("offset = [1, 0, 0]")), HasSubstr("offset"));
  EXPECT_THAT(refusal(with("predictions = \"nowhere\"")), HasSubstr((folder_ / "nowhere").string()));
  EXPECT_THAT(refusal(with("calibration = \"nowhere.toml\"")), HasSubstr("nowhere.toml"));
  EXPECT_THAT(refusal("[[recording]]\npath = \"nowhere\"\n"), HasSubstr((folder_ / "nowhere").string()));
  EXPECT_THAT(refusal("[[recording]]\ntranslation = [0, 0, 0]\n"), HasSubstr("path"));
  EXPECT_THAT(refusal("[[recording]]\npath = \"list.toml\"\n"), HasSubstr("list.toml is a list itself"));
  EXPECT_THAT(refusal("recording = []\n"), HasSubstr("names no recording"));
  EXPECT_THAT(refusal(""), HasSubstr("recording"));
  EXPECT_THAT(error_of(write(kTwo), folder_ / "c.toml"), HasSubstr("a list says the calibration of each of its recordings"));
}

// Two homes along these ways.
DoctorReport diagnose_two(const std::vector<Pose>& first, const std::vector<Pose>& second, const fs::path& list) {
  write_text(list, "[[recording]]\npath = \"first\"\n[[recording]]\npath = \"second\"\n");
  const RecordingList both(list, [&](const ListedRecording& r) -> std::unique_ptr<Dataset> {
    return std::make_unique<BoxRoom>(r.name == "first" ? first : second);
  });
  return diagnose(both, kPreflight);
}

TEST_F(List, TheDoctorLooksAtEachRecordingAndNamesIt) {
  const DoctorReport report = diagnose_two(walk_through_a_room().told, walk_through_a_room().told, folder_ / "list.toml");
  for (const char* name : {"first: ", "second: "}) {
    const auto of = [&](const Check& check) { return check.name == "depth scale" && check.evidence.starts_with(name); };
    EXPECT_EQ(std::count_if(report.checks.begin(), report.checks.end(), of), 1) << to_text(report);
  }
  EXPECT_LT(report.worst(), Verdict::kFailed) << to_text(report);
}

TEST_F(List, ARecordingThatLiesOnItsSideIsRefused) {
  const std::vector<Pose> upright = walk_through_a_room().told;
  Pose y_up = Pose::Identity();
  y_up.linear() << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  std::vector<Pose> lying;
  for (const Pose& pose : upright) lying.push_back(y_up * pose);
  const DoctorReport report = diagnose_two(upright, lying, folder_ / "list.toml");
  EXPECT_EQ(report.checks.back().verdict, Verdict::kImpossible);
  EXPECT_THAT(report.checks.back().evidence, HasSubstr("second: its upward direction (the cameras' mean -y axis) is 88 degrees"));
  EXPECT_THAT(report.checks.back().remedy, HasSubstr("rotation"));
}

}  // namespace
}  // namespace panoptic::test
