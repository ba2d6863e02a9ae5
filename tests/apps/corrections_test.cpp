// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// `panoptic rebuild` and `panoptic run --pose-updates`, from outside.
#include <algorithm>
#include <fstream>

#include "panoptic/base/files.h"
#include "panoptic/map_file.h"
#include "panoptic/query.h"
#include "tests/apps/run_fixture.h"

namespace panoptic {
namespace {

using test::expect_one_line;
using test::fresh_folder;
using test::ProgramResult;
using test::run_program;
using testing::HasSubstr;
namespace fs = std::filesystem;

constexpr double kAside_m = 0.3;

class Corrections : public test::Run {
 protected:
  Corrections() : predictions_(write_predictions()) {}

  ProgramResult map_recording(const std::vector<std::string>& more) const {
    std::vector<std::string> all{"run",           "--no-pictures",       recording_.string(), "-o",      out_.string(),
                                 "--predictions", predictions_.string(), kCoarse[0],          kCoarse[1]};
    all.insert(all.end(), more.begin(), more.end());
    return run_program(all);
  }
  ProgramResult rebuild(const fs::path& poses, const fs::path& to) const {
    return run_program({"rebuild", map_.string(), "--poses", poses.string(), "-o", to.string()});
  }
  // The trajectory of the run, every camera so far aside; TUM's form, or frames in place of times.
  fs::path trajectory(double aside_m, bool by_frame) const {
    std::ifstream in(out_ / "trajectory.txt");
    std::string text;
    std::int64_t frame = 0;
    for (std::string line; std::getline(in, line);) {
      double n[8];
      if (std::sscanf(line.c_str(), "%lf %lf %lf %lf %lf %lf %lf %lf", &n[0], &n[1], &n[2], &n[3], &n[4], &n[5], &n[6], &n[7]) !=
          8)
        continue;
      text += fmt::format("{} {} {} {} {} {} {} {}\n", by_frame ? static_cast<double>(frame++) : n[0], n[1] + aside_m, n[2], n[3],
                          n[4], n[5], n[6], n[7]);
    }
    const fs::path path = folder_ / fmt::format("poses_{}_{}.txt", aside_m, by_frame);
    write_file(path, text);
    return path;
  }
  // All cameras aside once the frame was mapped.
  fs::path updates(std::int64_t at_frame) const {
    std::string poses;
    for (const FrameRecord& record : load_frames(map_)) {
      if (!record.world_from_camera) continue;
      Pose pose = *record.world_from_camera;
      pose.translation().x() += kAside_m;
      Eigen::Matrix<double, 4, 4, Eigen::RowMajor> matrix = pose.matrix();
      poses += fmt::format("{}{{\"frame\": {}, \"pose\": [{}]}}", poses.empty() ? "" : ", ", record.frame,
                           fmt::join(matrix.data(), matrix.data() + 16, ", "));
    }
    write_file(folder_ / "updates.jsonl", fmt::format("{{\"at_frame\": {}, \"poses\": [{}]}}\n", at_frame, poses));
    return folder_ / "updates.jsonl";
  }
  static double chair_x(const fs::path& map) {
    const SavedMap saved = load_map(map);
    const auto chairs = MapQuery(saved.map).of_class("chair");
    EXPECT_EQ(chairs.size(), 1U);
    return chairs.empty() ? 0 : chairs[0].box.center_m.x();
  }

  fs::path predictions_;
  fs::path folder_ = fresh_folder("corrected");
  fs::path map_ = folder_ / "map.panoptic";
};

TEST_F(Corrections, ARebuiltMapHasTheSameThingsElsewhere) {
  ASSERT_EQ(map_recording({"--map", map_.string()}).exit_code, 0);
  const ProgramResult same = rebuild(trajectory(0, false), folder_ / "same.panoptic");
  ASSERT_EQ(same.exit_code, 0) << same.err;
  EXPECT_THAT(same.err, HasSubstr("no pose differs"));
  EXPECT_EQ(load_map(folder_ / "same.panoptic").map.voxels.hash(), load_map(map_).map.voxels.hash());

  for (const bool by_frame : {false, true}) {
    const fs::path moved = folder_ / (by_frame ? "by_frame.panoptic" : "by_time.panoptic");
    const ProgramResult result = rebuild(trajectory(kAside_m, by_frame), moved);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.out, HasSubstr("poses     for 12 of 12 frames, 12 of them other than before"));
    EXPECT_NEAR(chair_x(moved) - chair_x(map_), kAside_m, 0.03);
    const PanopticMap map = load_map(moved).map;
    EXPECT_EQ(map.objects.state().next_id, load_map(map_).map.objects.state().next_id) << "no new object";
    EXPECT_EQ(map.objects.count(), load_map(map_).map.objects.count());
  }
  expect_one_line(rebuild(trajectory(kAside_m, true), map_).err, "is there already");
  fs::rename(recording_, recording_.string() + "_moved");
  const ProgramResult lost = rebuild(trajectory(kAside_m, true), folder_ / "lost.panoptic");
  fs::rename(recording_.string() + "_moved", recording_);
  EXPECT_EQ(lost.exit_code, 1);
  expect_one_line(lost.err, "if it has moved, name it: --recording PATH");
  EXPECT_FALSE(is_there(folder_ / "lost.panoptic"));
}

TEST_F(Corrections, ACopiedLogNeedsNoRecording) {
  ASSERT_EQ(map_recording({"--map", map_.string()}).exit_code, 0);
  const fs::path poses = trajectory(kAside_m, true);
  ASSERT_EQ(rebuild(poses, folder_ / "read.panoptic").exit_code, 0);
  fs::remove(map_);
  ASSERT_EQ(map_recording({"--map", map_.string(), "--set", "map.log=copy"}).exit_code, 0);
  EXPECT_THAT(run_program({"info", map_.string()}).out, HasSubstr("12 frames, 12 with copies of their images"));
  fs::rename(recording_, recording_.string() + "_moved");
  const ProgramResult result = rebuild(poses, folder_ / "copied.panoptic");
  fs::rename(recording_.string() + "_moved", recording_);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("poses     for 12 of 12 frames, 12 of them other than before"));
  EXPECT_EQ(load_map(folder_ / "copied.panoptic").map.voxels.hash(), load_map(folder_ / "read.panoptic").map.voxels.hash());
}

TEST_F(Corrections, OfARunAreFollowedAndReported) {
  ASSERT_EQ(map_recording({"--map", map_.string()}).exit_code, 0);
  const fs::path corrected = folder_ / "corrected.panoptic";
  const ProgramResult result = map_recording({"--map", corrected.string(), "--pose-updates", updates(11).string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("1 corrections moved 12 poses"));
  const Json corrections = report()["corrections"];
  ASSERT_EQ(corrections.size(), 1U);
  EXPECT_EQ(corrections[0]["frames"], 12);
  EXPECT_EQ(corrections[0]["blocks_refused"], corrections[0]["blocks"]);
  EXPECT_NEAR(chair_x(corrected) - chair_x(map_), kAside_m, 0.03);
  EXPECT_EQ(report()["map_hash"], fmt::format("{:016x}", load_map(corrected).map.voxels.hash()));
}

TEST_F(Corrections, OfAnOnlineRunAreFollowedAtTheSameMoment) {
  ASSERT_EQ(map_recording({"--map", map_.string()}).exit_code, 0);
  const std::string poses = updates(5).string();
  ASSERT_EQ(map_recording({"--pose-updates", poses}).exit_code, 0);
  const Json offline = report()["corrections"];
  const fs::path corrected = folder_ / "corrected.panoptic";
  const ProgramResult result =
      map_recording({"--online", "--speed", "max", "--map", corrected.string(), "--pose-updates", poses});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json corrections = report()["corrections"];
  ASSERT_EQ(corrections.size(), 1U);
  EXPECT_EQ(corrections[0]["frames"], 6);
  EXPECT_EQ(corrections[0]["unknown"], offline[0]["unknown"]) << "those behind frame 5 are not in the map yet";
  EXPECT_EQ(corrections[0]["blocks"], offline[0]["blocks"]);
  EXPECT_LT(corrections[0]["pause_ms"].get<double>(), corrections[0]["ms"].get<double>());
  EXPECT_EQ(load_frames(corrected).size(), 12U);
}

TEST_F(Corrections, WrongOnesAreOneLine) {
  write_file(folder_ / "nonsense.jsonl", "{\n");
  const ProgramResult nonsense = map_recording({"--pose-updates", (folder_ / "nonsense.jsonl").string()});
  EXPECT_EQ(nonsense.exit_code, 1);
  expect_one_line(nonsense.err, "nonsense.jsonl line 1 is not JSON");
  EXPECT_EQ(map_recording({"--online", "--pose-updates", "x"}).exit_code, 1);
  EXPECT_EQ(run_program({"rebuild", map_.string()}).exit_code, 2);
}

}  // namespace
}  // namespace panoptic
