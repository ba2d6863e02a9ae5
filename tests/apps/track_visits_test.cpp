// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// `panoptic run --track --in`: a further visit whose camera is found in the saved map.
#include <gmock/gmock.h>

#include "panoptic/io/pose_list.h"
#include "tests/apps/run_fixture.h"
#include "tests/apps/tracked_room.h"

namespace panoptic {
namespace {

using test::expect_one_line;
using test::ProgramResult;
using testing::HasSubstr;
namespace fs = std::filesystem;

constexpr int kFirstFrames = 12;
constexpr int kStart = 5;  // of the second visit, on the way round
constexpr int kSecondFrames = 4;

class TrackVisits : public test::TrackedRoom {
 protected:
  TrackVisits() : first_(recording("first", 0, kFirstFrames)), second_(recording("second", kStart, kSecondFrames)) {}

  void map_first() const { ASSERT_EQ(run_over(first_, {"--map", first_map().string()}).exit_code, 0); }
  ProgramResult map_second(const fs::path& second, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> all{"--in", first_map().string(), "--map", second_map().string()};
    all.insert(all.end(), more.begin(), more.end());
    return run_over(second, all);
  }
  // The lines of the run's trajectory, each its numbers.
  std::vector<std::string> lines_of(const fs::path& file) const {
    std::vector<std::string> lines;
    std::istringstream text(read_file(file));
    for (std::string line; std::getline(text, line);) {
      if (!line.starts_with("#")) lines.push_back(line);
    }
    return lines;
  }
  fs::path first_map() const { return folder_ / "first.panoptic"; }
  fs::path second_map() const { return folder_ / "second.panoptic"; }

  const fs::path first_;
  const fs::path second_;
};

TEST_F(TrackVisits, TheCameraIsFoundInTheSavedMapWhichStaysAsItIs) {
  map_first();
  const std::string before = read_file(first_map());
  const std::vector<std::string> first_way = lines_of(out_ / "trajectory.txt");
  const ProgramResult result = map_second(second_);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("poses     none: the camera is looked for in"));
  EXPECT_THAT(result.out, HasSubstr("after 0 frames that are not in the map"));
  EXPECT_EQ(read_file(first_map()), before);
  EXPECT_EQ(report()["frames"]["used"], kFirstFrames + kSecondFrames);
  EXPECT_EQ(report()["tracking"]["spans"][0]["state"], "found again");
  EXPECT_EQ(report()["tracking"]["tracked"], kSecondFrames);
  // The second visit shows what frames of the first do, so it stands where they did.
  const std::vector<std::string> way = lines_of(out_ / "trajectory.txt");
  ASSERT_EQ(way.size(), static_cast<std::size_t>(kFirstFrames + kSecondFrames));
  for (int n = 0; n < kSecondFrames; ++n) {
    double time = 0;
    Vec3d a;
    Vec3d b;
    std::istringstream(first_way[static_cast<std::size_t>(kStart + n)]) >> time >> a.x() >> a.y() >> a.z();
    std::istringstream(way[static_cast<std::size_t>(kFirstFrames + n)]) >> time >> b.x() >> b.y() >> b.z();
    EXPECT_LT((a - b).norm(), 0.02) << n;
  }
}

TEST_F(TrackVisits, TheTrajectoryIsTheSameForAnyNumberOfThreads) {
  map_first();
  ASSERT_EQ(map_second(second_, {"--threads", "1"}).exit_code, 0);
  const std::string one = read_file(out_ / "trajectory.txt");
  fs::remove(second_map());
  ASSERT_EQ(map_second(second_, {"--threads", "3"}).exit_code, 0);
  EXPECT_EQ(read_file(out_ / "trajectory.txt"), one);
}

TEST_F(TrackVisits, AThirdVisitGoesOnFromTheSecondAndItsMapIsRebuilt) {
  map_first();
  // Poses of its own, with gaps, which nobody asked for: every frame is found by what it shows.
  write_file(second_ / "frame-000001.pose.txt", "1 0 0 9\n0 1 0 9\n0 0 1 9\n0 0 0 1\n");
  ASSERT_EQ(map_second(second_, {"--track"}).exit_code, 0);
  const fs::path third_map = folder_ / "third.panoptic";
  const ProgramResult third = run_over(second_, {"--track", "--in", second_map().string(), "--map", third_map.string()});
  ASSERT_EQ(third.exit_code, 0) << third.err;
  EXPECT_EQ(report()["frames"]["used"], kFirstFrames + 2 * kSecondFrames);
  std::string moved;
  for (const std::string& line : lines_of(out_ / "trajectory.txt")) {
    std::istringstream text(line);
    std::string time;
    double x = 0;
    std::string rest;
    text >> time >> x;
    std::getline(text, rest);
    moved += fmt::format("{} {}{}\n", time, x + 0.5, rest);
  }
  write_file(folder_ / "moved.txt", moved);
  const ProgramResult rebuilt = test::run_program(
      {"rebuild", third_map.string(), "--poses", (folder_ / "moved.txt").string(), "-o", (folder_ / "new.panoptic").string()});
  ASSERT_EQ(rebuilt.exit_code, 0) << rebuilt.err;
  const int frames = kFirstFrames + 2 * kSecondFrames;
  EXPECT_THAT(rebuilt.out, HasSubstr(fmt::format("poses     for {0} of {0} frames, {0} of them other", frames)));
}

TEST_F(TrackVisits, AnInterruptedVisitSaysHowToGoOn) {
  map_first();
  ASSERT_EQ(map_second(second_).exit_code, 0);
  const ProgramResult resumed = map_second(second_, {"--resume"});
  EXPECT_EQ(resumed.exit_code, 1);
  expect_one_line(resumed.err, "remove it and " + second_map().string() + ".visits.toml, and run without --resume");
  const ProgramResult plain = run_over(second_map().string() + ".visits.toml", {});
  EXPECT_EQ(plain.exit_code, 1);
  expect_one_line(plain.err, "its camera was tracked (tracked = true)");
}

TEST_F(TrackVisits, ACameraThatIsNeverFoundIsNoSuccess) {
  map_first();
  const fs::path elsewhere = folder_ / "elsewhere";
  fs::create_directories(elsewhere);
  fs::copy(second_ / "camera-intrinsics.txt", elsewhere / "camera-intrinsics.txt");
  for (int n = 0; n < 3; ++n) {
    Frame wall = test::render(test::bare_wall(), test::room_camera(), test::look_at({0, 0, 1.2}, {0.1 * n, 0, 2}), n);
    wall.world_from_camera.translation() += Vec3d(7, 3, 5);
    write_frame(elsewhere, n, test::paint(wall));
  }
  const ProgramResult result = map_second(elsewhere);
  EXPECT_EQ(result.exit_code, 1);
  expect_one_line(result.err, "was not found in " + first_map().string() + ", 3 frames are lost");
  EXPECT_EQ(report()["tracking"]["lost"], 3);
  EXPECT_EQ(report()["frames"]["used"], kFirstFrames);
  EXPECT_TRUE(is_file(out_ / "scene.glb"));
}

TEST_F(TrackVisits, WhatItCannotGoOnFromIsRefusedInOneLine) {
  map_first();
  for (int n = 0; n < kSecondFrames; ++n) {
    write_file(second_ / fmt::format("frame-{:06}.pose.txt", n), "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  }
  const ProgramResult posed = map_second(second_);
  EXPECT_EQ(posed.exit_code, 1);
  expect_one_line(posed.err, "its camera was tracked");
  fs::rename(first_, folder_ / "moved");
  const ProgramResult gone = map_second(second_, {"--track"});
  EXPECT_EQ(gone.exit_code, 1);
  expect_one_line(gone.err, first_.string());
  EXPECT_FALSE(is_there(second_map()));
}

}  // namespace
}  // namespace panoptic
