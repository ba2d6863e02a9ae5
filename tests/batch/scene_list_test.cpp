// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/batch/scene_list.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panoptic/base/files.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

using test::fresh_folder;
using testing::ElementsAre;
namespace fs = std::filesystem;

std::vector<std::string> names_of(const SceneList& list) {
  std::vector<std::string> names;
  for (const BatchScene& scene : list.scenes) names.push_back(scene.name);
  return names;
}

std::string why(const fs::path& list) {
  try {
    read_scenes(list);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(SceneList, OfAFileHasItsLinesInTheirOrder) {
  const fs::path folder = fresh_folder();
  fs::create_directories(folder / "scans" / "b");
  fs::create_directories(folder / "a b");
  write_file(folder / "c.sens", "x");
  write_file(folder / "list.txt", "# scans\n\n scans/b/ \r\nsim:7,rooms=2\na b\n" + (folder / "c.sens").string());
  const SceneList list = read_scenes(folder / "list.txt");
  EXPECT_THAT(names_of(list), ElementsAre("b", "sim_7_rooms_2", "a_b", "c"));
  EXPECT_EQ(list.scenes[0].recording, (folder / "scans" / "b").string());
  EXPECT_EQ(list.scenes[1].recording, "sim:7,rooms=2");
}

TEST(SceneList, OfAFolderHasItsFoldersAndScansButForOurOwn) {
  const fs::path folder = fresh_folder();
  for (const char* name : {"z", "out", ".hidden", "a"}) fs::create_directories(folder / name);
  write_file(folder / "m.sens", "x");
  write_file(folder / "notes.txt", "x");
  const SceneList list = read_scenes(folder, {folder / "out" / ""});
  EXPECT_THAT(names_of(list), ElementsAre("a", "m", "z"));
  EXPECT_THAT(list.left_out, ElementsAre("notes.txt"));
}

TEST(SceneList, HasBagsAndTheTopicsThatAreChosenOfThem) {
  const fs::path folder = fresh_folder();
  write_file(folder / "walk.mcap", "x");
  write_file(folder / "home.bag", "x");
  EXPECT_THAT(names_of(read_scenes(folder)), ElementsAre("home", "walk"));
  write_file(folder / "list.txt", "walk.mcap?depth=/camera/depth\nhome.bag\n");
  const SceneList list = read_scenes(folder / "list.txt");
  EXPECT_THAT(names_of(list), ElementsAre("walk", "home"));
  EXPECT_EQ(list.scenes[0].recording, (folder / "walk.mcap").string() + "?depth=/camera/depth");
  write_file(folder / "wrong.txt", "run.bag?depth=/camera/depth\n");
  EXPECT_THAT(why(folder / "wrong.txt"), testing::HasSubstr("run.bag"));
}

TEST(SceneList, PutsFoldersInFrontWhereSeveralHaveOneName) {
  const fs::path folder = fresh_folder();
  for (const char* name : {"chess/seq-01", "fire/seq-01", "fire/seq-02"}) fs::create_directories(folder / name);
  write_file(folder / "list.txt", "chess/seq-01\nfire/seq-01\nfire/seq-02\n");
  EXPECT_THAT(names_of(read_scenes(folder / "list.txt")), ElementsAre("chess_seq-01", "fire_seq-01", "seq-02"));
}

TEST(SceneList, RefusesWhatCannotBeToldApartOrIsNotThere) {
  const fs::path folder = fresh_folder();
  const fs::path list = folder / "list.txt";
  for (const char* name : {"a", "batch.json", "x/y_z", "x_y/z"}) fs::create_directories(folder / name);
  write_file(list, "a\nb\n");
  EXPECT_THAT(why(list), testing::HasSubstr("list.txt:2: there is no"));
  write_file(list, "a\n./a/\n");
  EXPECT_THAT(why(list), testing::HasSubstr("is named twice"));
  write_file(list, "batch.json\n");
  EXPECT_THAT(why(list), testing::HasSubstr("a scene cannot be called 'batch.json'"));
  write_file(list, "sim:1,rooms=2\nsim:1_rooms=2\n");
  EXPECT_THAT(why(list), testing::HasSubstr("would both be called sim_1_rooms_2"));
  write_file(list, "# nothing\n");
  EXPECT_THAT(why(list), testing::HasSubstr("no recordings here"));
  EXPECT_THAT(why(folder / "absent.txt"), testing::HasSubstr("absent.txt"));
}

}  // namespace
}  // namespace panoptic
