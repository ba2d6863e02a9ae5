// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/batch/fingerprint.h"

#include <gtest/gtest.h>

#include <chrono>

#include "panoptic/base/files.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

using test::fresh_folder;
namespace fs = std::filesystem;

std::string of(const std::string& recording) {
  Fingerprint fingerprint;
  add_recording(fingerprint, recording);
  return fingerprint.text();
}

TEST(Fingerprint, TellsWhereOneTextEndsAndTheNextBegins) {
  Fingerprint a;
  Fingerprint b;
  a.add("ab");
  a.add("c");
  b.add("a");
  b.add("bc");
  EXPECT_NE(a.text(), b.text());
}

TEST(Fingerprint, ChangesWithEveryFileOfARecording) {
  const fs::path folder = fresh_folder();
  fs::create_directories(folder / "depth");
  write_file(folder / "depth" / "0.png", "a");
  write_file(folder / "pose.txt", "b");
  const std::string before = of(folder.string());
  EXPECT_EQ(of(folder.string()), before);
  write_file(folder / "depth" / "1.png", "c");
  const std::string added = of(folder.string());
  EXPECT_NE(added, before);
  fs::last_write_time(folder / "pose.txt", fs::last_write_time(folder / "pose.txt") - std::chrono::hours(1));
  EXPECT_NE(of(folder.string()), added);
  fs::remove_all(folder);
  EXPECT_NE(of(folder.string()), added);
  EXPECT_NE(of("sim:1"), of("sim:2"));
}

TEST(Fingerprint, LooksIntoListsOfRecordings) {
  const fs::path folder = fresh_folder();
  fs::create_directories(folder / "home");
  write_file(folder / "home" / "a.txt", "a");
  write_file(folder / "list.toml", "[[recording]]\npath = \"home\"\n");
  const std::string before = of((folder / "list.toml").string());
  write_file(folder / "home" / "b.txt", "b");
  EXPECT_NE(of((folder / "list.toml").string()), before);
}

}  // namespace
}  // namespace panoptic
