// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Folders for the files of tests: apart from those of every other test and of other processes that run the same test, and
// removed when the process ends, unless PANOPTIC_KEEP_TEST_FILES is set.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace panoptic::test {

// All files of this process.
class TestFiles {
 public:
  TestFiles() : owner_(::getpid()), root_(std::filesystem::path(testing::TempDir()) / ("panoptic_" + std::to_string(owner_))) {}
  ~TestFiles() {
    std::error_code ignored;
    const bool is_fork = ::getpid() != owner_;
    if (!is_fork && std::getenv("PANOPTIC_KEEP_TEST_FILES") == nullptr) std::filesystem::remove_all(root_, ignored);
  }
  TestFiles(const TestFiles&) = delete;
  TestFiles& operator=(const TestFiles&) = delete;

  const std::filesystem::path& root() const { return root_; }

 private:
  pid_t owner_;
  std::filesystem::path root_;
};

// An empty folder of the running test's own, called `name`; the same name gives the same folder, emptied.
inline std::filesystem::path fresh_folder(const std::string& name = "files") {
  static const TestFiles kFiles;
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  std::filesystem::path folder = kFiles.root() / info->test_suite_name() / info->name() / name;
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

}  // namespace panoptic::test
