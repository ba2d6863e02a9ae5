// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// map.log = copy: corrections of poses without the recording.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panoptic/base/files.h"
#include "panoptic/base/sqlite.h"
#include "panoptic/frame_statistics.h"
#include "panoptic/map/frame_images.h"
#include "panoptic/mapfile/map_rows.h"
#include "panoptic/mapping/rebuild_file.h"
#include "panoptic/mapping/regularize_file.h"
#include "panoptic/online.h"
#include "panoptic/run_outputs.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/mapping/drifting.h"
#include "tests/places.h"

namespace panoptic {
namespace {

using namespace test::drifting;
using test::error_of;
using testing::HasSubstr;
namespace fs = std::filesystem;

const PanopticMap& mapped(const std::unique_ptr<Mapper>& mapper) { return mapper->map(); }

TEST(CopiedFrames, GiveTheMapThatTheRecordingGivesBitForBit) {
  Mapper copied(copying(), test::test_labels());
  Mapper referred(often(), test::test_labels());
  for (Mapper* mapper : {&copied, &referred}) add_frames(*mapper);
  EXPECT_EQ(hashes_of(copied.map()), hashes_of(referred.map()));
  const Correction correction = copied.update_poses(true_poses(20));
  EXPECT_EQ(correction.frames, 19U);
  referred.update_poses(true_poses(20), read_again);
  EXPECT_EQ(hashes_of(copied.map()), hashes_of(referred.map()));
  copied.update_poses(true_poses());
  referred.update_poses(true_poses(), read_again);
  EXPECT_EQ(hashes_of(copied.map()), hashes_of(referred.map()));
  EXPECT_THAT(error_of([&] {
                referred.update_poses({{{3, Pose::Identity()}}});
              }),
              HasSubstr("frame 0 cannot be read again: the log has no copy of it"));
}

TEST(CopiedFrames, BeyondTheLimitACorrectionIsRefused) {
  Options options = copying();
  options.map.log_limit_mb = 1;
  Mapper mapper(options, test::test_labels());
  std::int64_t index = 0;
  while (mapper.parts().log().bytes() < 1'000'000 && index < 3000) {
    Frame frame = drifted_frame(static_cast<int>(index % kFrames));
    frame.index = index++;
    ASSERT_TRUE(mapper.add(frame, {}).used);
  }
  EXPECT_LT(index, 3000) << "images count";
  Frame one_more = drifted_frame(0);
  one_more.index = index;
  ASSERT_TRUE(mapper.add(one_more, {}).used);
  EXPECT_THAT(error_of([&] { mapper.update_poses(true_poses(3)); }), HasSubstr("frames used; raise map.log_limit_mb (1)"));
}

class CopiesInAFile : public testing::Test {
 protected:
  std::unique_ptr<Mapper> map_copied(std::size_t end = kFrames, bool complete = true) const {
    return map_to_file(map_, end, complete, std::nullopt, copying());
  }
  RebuiltFile rebuild(const fs::path& map, const fs::path& to, const Dataset* recording = nullptr) const {
    std::string text;
    for (const PoseUpdate& update : true_poses()) {
      text += fmt::format("{}", update.frame);
      for (int k = 0; k < 12; ++k) text += fmt::format(" {:.17g}", update.world_from_camera.matrix()(k / 4, k % 4));
      text += "\n";
    }
    write_file(folder_ / "poses.txt", text);
    return rebuild_map_file(map, folder_ / "poses.txt", recording, to);
  }
  // Goes on with the map file to the end: all frames have copies, and give the map that the recording gives.
  void expect_resumed_to_be_whole() const {
    const auto resumed = map_copied();
    const auto referred = map_to_file(folder_ / "referred.panoptic", kFrames, true);
    EXPECT_EQ(size_of_log(map_).copies, resumed->frames().used());
    resumed->update_poses(true_poses());
    referred->update_poses(true_poses(), read_again);
    EXPECT_EQ(hashes_of(mapped(resumed)), hashes_of(mapped(referred)));
  }
  std::string damage(const char* sql) const {
    const fs::path damaged = fs::path(map_.string() + ".damaged");
    fs::copy_file(map_, damaged, fs::copy_options::overwrite_existing);
    Database(damaged, DatabaseAccess::kWrite).execute(sql);
    return error_of([&] { rebuild(damaged, folder_ / "refused.panoptic"); });
  }

  fs::path folder_ = test::fresh_folder();
  fs::path map_ = folder_ / "copied.panoptic";
};

TEST_F(CopiesInAFile, AreAllThatARebuildNeeds) {
  const auto copied = map_copied();
  const auto referred = map_to_file(folder_ / "referred.panoptic", kFrames, true);
  EXPECT_EQ(hashes_of(mapped(copied)), hashes_of(mapped(referred)));
  const LogSize size = size_of_log(map_);
  EXPECT_EQ(size.copies, size.frames);
  EXPECT_TRUE(has_copies(map_));
  EXPECT_FALSE(has_copies(folder_ / "referred.panoptic"));

  const Drifting recording;
  rebuild(folder_ / "referred.panoptic", folder_ / "read.panoptic", &recording);
  EXPECT_EQ(rebuild(map_, folder_ / "new.panoptic").left_over, 4U) << "frames that could not be read";
  EXPECT_EQ(hashes_of(load_map(folder_ / "new.panoptic").map), hashes_of(load_map(folder_ / "read.panoptic").map));
  EXPECT_THAT(error_of([&] { rebuild(folder_ / "referred.panoptic", folder_ / "lost.panoptic"); }),
              HasSubstr("frame 0 cannot be read again: the log has no copy of it"));
  // The new file has the copies, too.
  fs::remove(map_);
  EXPECT_EQ(rebuild(folder_ / "new.panoptic", folder_ / "again.panoptic").correction.frames, 0U);
  EXPECT_TRUE(has_copies(folder_ / "again.panoptic"));
}

TEST_F(CopiesInAFile, AreReadFromThereByTheRunThatWroteThem) {
  const auto copied = map_copied();
  const auto referred = map_to_file(folder_ / "referred.panoptic", kFrames, true);
  copied->update_poses(true_poses());
  referred->update_poses(true_poses(), read_again);
  EXPECT_EQ(hashes_of(mapped(copied)), hashes_of(mapped(referred)));
  Database(map_, DatabaseAccess::kWrite).execute("DELETE FROM frame_images WHERE number = 4");
  EXPECT_THAT(error_of([&] {
                copied->update_poses({{{3, Pose::Identity()}}});
              }),
              HasSubstr("it has no images of frame 12"))
      << "they are not in memory";
}

TEST_F(CopiesInAFile, ComeThroughARunThatGoesOn) {
  map_copied(17, false);
  expect_resumed_to_be_whole();
}

// A run that ends before its next checkpoint.
TEST_F(CopiesInAFile, AreWrittenAheadAndOfNoUseUntilTheCheckpoint) {
  {
    Mapper mapper(copying(), test::test_labels());
    Checkpoints checkpoints({.path = map_, .every_s = 3600, .copies_bytes = 20'000}, identity(copying()), mapper);
    for (int i = 0; i < 20; ++i) {
      checkpoints.note(record_of(drifted_frame(i), false, mapper.add(drifted_frame(i), {})));
      checkpoints.after_frame(mapper);
    }
  }
  EXPECT_GT(Database(map_, DatabaseAccess::kRead).integer("SELECT count(*) FROM frame_images"), 8);
  EXPECT_EQ(size_of_log(map_).copies, 0U);
  EXPECT_TRUE(load_log(map_).empty());
  expect_resumed_to_be_whole();
}

TEST_F(CopiesInAFile, AreThereAfterACorrectionOnTheWay) {
  map_to_file(map_, kFrames, true, 15, copying());
  map_to_file(folder_ / "referred.panoptic", kFrames, true, 15);
  const Drifting recording;
  rebuild(folder_ / "referred.panoptic", folder_ / "read.panoptic", &recording);
  rebuild(map_, folder_ / "new.panoptic");
  EXPECT_EQ(hashes_of(load_map(folder_ / "new.panoptic").map), hashes_of(load_map(folder_ / "read.panoptic").map));
}

TEST_F(CopiesInAFile, ThatAreSavedAtOnce) {
  Mapper mapper(copying(), test::test_labels());
  add_frames(mapper);
  mapper.finish();
  save_map(map_, mapper, copying());
  rebuild(map_, folder_ / "new.panoptic");
  mapper.update_poses(true_poses());
  EXPECT_EQ(load_map(folder_ / "new.panoptic").map.voxels.hash(), mapper.map().voxels.hash());
}

TEST_F(CopiesInAFile, BadOnesAreRefused) {
  map_copied(9);
  EXPECT_THAT(damage("UPDATE frame_images SET images = zeroblob(500) WHERE number = 3"),
              HasSubstr("the images of frame 9 of its log: their checksum is wrong"));
  EXPECT_THAT(damage("UPDATE frame_images SET number = 100 WHERE number = 3"), HasSubstr("frame 9 cannot be read again"));
  EXPECT_THAT(damage("UPDATE frame_images SET number = -1 WHERE number = 3"), HasSubstr("it has images of entry -1"));
  EXPECT_THAT(damage("DELETE FROM frame_images WHERE number = 3"), HasSubstr("frame 9 cannot be read again"));
  const Bytes garbage = {1, 2, 3};
  const std::string sql =
      fmt::format("UPDATE frame_images SET images = x'010203', checksum = {} WHERE number = 3", row_checksum({3, 9}, garbage));
  EXPECT_THAT(damage(sql.c_str()), HasSubstr("frame 9 cannot be read again: its images in the log are damaged"));
  EXPECT_FALSE(is_there(folder_ / "refused.panoptic"));
}

// A file of today but for the table of copies is what format 5 was.
TEST_F(CopiesInAFile, AreNotNeededByOlderFilesWithALog) {
  const fs::path old = folder_ / "old.panoptic";
  map_to_file(old, kFrames, true);
  const Drifting recording;
  rebuild(old, folder_ / "of_six.panoptic", &recording);
  Database(old, DatabaseAccess::kWrite).execute("DROP TABLE frame_images; PRAGMA user_version = 5;");
  EXPECT_FALSE(has_copies(old));
  rebuild(old, folder_ / "of_five.panoptic", &recording);
  EXPECT_EQ(hashes_of(load_map(folder_ / "of_five.panoptic").map), hashes_of(load_map(folder_ / "of_six.panoptic").map));
  const std::size_t logged = load_log(old).size();
  EXPECT_THAT(regularize_map_file(old, {}).note, HasSubstr("has format 5, which lacks copies of its frames"));
  EXPECT_EQ(load_map(old).format, kMapFormat);
  EXPECT_EQ(load_log(old).size(), logged) << "it is saved anew with its log";
}

// A map of three frames, with copies of them.
TEST(MapFormat, SixStillLoads) {
  const fs::path path = test::source_folder() / "tests/golden/format_6.panoptic";
  const SavedMap golden = load_map(path);
  EXPECT_EQ(golden.format, 6);
  EXPECT_EQ(note_of_format(golden, path), "") << "nothing is missing";
  EXPECT_EQ(fmt::format("{:016x}", golden.map.voxels.hash()), "157056fd0f8ac071");
  const std::vector<FrameLog::Entry> log = load_log(path);
  ASSERT_EQ(log.size(), 3U);
  for (const FrameLog::Entry& entry : log) {
    ASSERT_NE(entry.images, nullptr);
    const auto frame = unpack_images(*entry.images->packed());
    ASSERT_TRUE(frame.has_value());
    EXPECT_TRUE(check(*frame).used);
  }
}

TEST(OnlineCopies, NeedNobodyWhoReadsFramesAgain) {
  Options options = copying();
  options.regularizer.enabled = false;
  Mapper offline(options, test::test_labels());
  for (int i = 0; i < 12; ++i) ASSERT_TRUE(offline.add(drifted_frame(i), {}).used);
  offline.update_poses(true_poses(12));
  offline.finish();
  Mapper mapper(options, test::test_labels());
  OnlinePipeline pipeline({mapper}, {});
  for (int i = 0; i < 12; ++i) ASSERT_TRUE(pipeline.push_when_free(drifted_frame(i)));
  ASSERT_TRUE(pipeline.update_poses(true_poses(12)));
  EXPECT_EQ(pipeline.finish().stopped_by, "");
  EXPECT_EQ(hashes_of(mapper.map()), hashes_of(offline.map()));
}

}  // namespace
}  // namespace panoptic
