// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapping/rebuild_file.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panoptic/base/files.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/mapping/drifting.h"
#include "tests/places.h"

namespace panoptic {
namespace {

using namespace test::drifting;
using test::error_of;
using testing::HasSubstr;

TEST(Correction, IsInTheMapFileAndARunGoesOnFromThere) {
  const auto folder = test::fresh_folder();
  const auto whole = map_to_file(folder / "whole.panoptic", kFrames, true, 15);
  const auto half = map_to_file(folder / "half.panoptic", 18, false, 15);
  const SavedMap saved = load_map(folder / "half.panoptic");
  EXPECT_EQ(hashes_of(saved.map), hashes_of(half->map()));
  for (const FrameRecord& record : load_frames(folder / "half.panoptic")) {
    if (!record.unused_because.empty()) continue;
    const auto i = static_cast<int>(record.frame / 3);
    EXPECT_TRUE(record.world_from_camera->isApprox(i < 15 ? true_frame(i).world_from_camera : drifted(i), 1e-9)) << i;
  }
  const auto resumed = map_to_file(folder / "half.panoptic", kFrames, true);
  EXPECT_EQ(hashes_of(resumed->map()), hashes_of(whole->map()));
  EXPECT_EQ(hashes_of(load_map(folder / "half.panoptic").map), hashes_of(whole->map()));
  // The log came through the file: a correction now is that of the run that was never interrupted.
  whole->update_poses(true_poses(), read_again);
  resumed->update_poses(true_poses(), read_again);
  EXPECT_EQ(hashes_of(resumed->map()), hashes_of(whole->map()));
}

std::string trajectory(bool by_time) {
  std::string text = "# x y z qx qy qz qw after a number\n";
  for (int i = 0; i < kFrames; ++i) {
    const Pose pose = true_frame(i).world_from_camera;
    const Eigen::Quaterniond q(pose.linear());
    text += fmt::format("{} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g}\n", by_time ? 0.1 * i + 0.004 : 3.0 * i,
                        pose.translation().x(), pose.translation().y(), pose.translation().z(), q.x(), q.y(), q.z(), q.w());
  }
  return text;
}

class Rebuild : public testing::Test {
 protected:
  RebuiltFile rebuild(const std::string& poses, const std::filesystem::path& output) {
    write_file(folder_ / "poses.txt", poses);
    return rebuild_map_file(map_, folder_ / "poses.txt", &recording_, output);
  }
  std::string error(const std::string& poses) {
    return error_of([&] { rebuild(poses, folder_ / "refused.panoptic"); });
  }

  std::filesystem::path folder_ = test::fresh_folder();
  std::filesystem::path map_ = folder_ / "drifted.panoptic";
  Drifting recording_;
};

TEST_F(Rebuild, MakesAMapFileAnewAsIfItsRunHadBeenCorrected) {
  const auto mapper = map_to_file(map_, kFrames, true);
  const std::uint64_t before = load_map(map_).map.voxels.hash();
  const RebuiltFile rebuilt = rebuild(trajectory(false), folder_ / "new.panoptic");
  EXPECT_EQ(rebuilt.used, mapper->frames().used());
  EXPECT_EQ(rebuilt.given, rebuilt.used);
  EXPECT_EQ(rebuilt.correction.unknown, 4U) << "frames that could not be read";

  std::vector<FrameTime> times;
  for (int i = 0; i < kFrames; ++i) times.push_back({3 * i, 0.1 * i});
  mapper->update_poses(read_corrected_poses(folder_ / "poses.txt", times).poses, read_again);
  const SavedMap saved = load_map(folder_ / "new.panoptic");
  EXPECT_EQ(hashes_of(saved.map), hashes_of(mapper->map()));
  EXPECT_EQ(saved.map.objects.state(), mapper->map().objects.state());
  EXPECT_EQ(load_map(map_).map.voxels.hash(), before);
  for (const FrameRecord& record : load_frames(folder_ / "new.panoptic")) {
    if (!record.unused_because.empty()) continue;
    EXPECT_TRUE(record.world_from_camera->isApprox(true_frame(static_cast<int>(record.frame / 3)).world_from_camera, 1e-9));
  }

  rebuild(trajectory(true), folder_ / "by_time.panoptic");
  EXPECT_EQ(load_map(folder_ / "by_time.panoptic").map.voxels.hash(), saved.map.voxels.hash());
  // A map that was made anew can be made anew.
  const RebuiltFile again =
      rebuild_map_file(folder_ / "new.panoptic", folder_ / "poses.txt", &recording_, folder_ / "again.panoptic");
  EXPECT_EQ(again.correction.frames, 0U);
  EXPECT_EQ(load_map(folder_ / "again.panoptic").map.voxels.hash(), saved.map.voxels.hash());
}

TEST_F(Rebuild, SaysWhatIsWrong) {
  map_to_file(map_, 12, false);
  EXPECT_THAT(error("1 2 3\n"), HasSubstr("poses.txt"));
  EXPECT_THAT(error("0 0 0 0 0 0 1\n0 0 1 0 0 0 1\n"), HasSubstr("its poses have no numbers"));
  EXPECT_THAT(error("500.5 0 0 0 0 0 0 1\n501.5 0 0 1 0 0 0 1\n"),
              HasSubstr("of its 2 poses 0 have the number of a frame of the map, and 0 are within 20 ms of one"));
  EXPECT_FALSE(is_there(folder_ / "refused.panoptic"));
  EXPECT_THAT(error_of([&] { rebuild(trajectory(false), map_); }), HasSubstr("is there already"));

  std::filesystem::copy_file(test::source_folder() / "tests/golden/format_3.panoptic", folder_ / "old.panoptic");
  map_ = folder_ / "old.panoptic";
  EXPECT_THAT(error(trajectory(false)), HasSubstr("has format 3, which lacks the log of its frames"));
}

TEST_F(Rebuild, ARunDoesNotGoOnFromAMapWithOtherPoses) {
  map_to_file(map_, 12, false);
  EXPECT_EQ(rebuild(trajectory(false), folder_ / "new.panoptic").left_over, 30U - 11U) << "the map ends earlier";
  EXPECT_THAT(error_of([&] { map_to_file(folder_ / "new.panoptic", 14, false); }), HasSubstr("was rebuilt with corrected poses"));
}

}  // namespace
}  // namespace panoptic
