// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A fresh folder for the files of one test, removed at its end.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <string>

namespace panoptic::test {

class TempFolder {
 public:
  TempFolder() : path_(unique_path()) { std::filesystem::create_directories(path_); }
  ~TempFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  static std::filesystem::path unique_path() {
    static std::atomic<int> count{0};
    const std::string name = "panoptic_" + std::to_string(::getpid()) + "_" + std::to_string(count++);
    return std::filesystem::path(testing::TempDir()) / name;
  }

  std::filesystem::path path_;
};

}  // namespace panoptic::test
