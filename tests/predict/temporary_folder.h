// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

namespace panoptic::test {

// An empty folder of the running test's own. It stays, so that pictures can be looked at after the test.
inline std::filesystem::path fresh_folder(const std::string& name = "files") {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / "panoptic_predict" / info->test_suite_name() / info->name() / name;
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

}  // namespace panoptic::test
