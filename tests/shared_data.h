// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Where the tests find recordings, networks and specifications that are not part of the repository.
#pragma once

#include <gtest/gtest.h>

#include "tests/places.h"

#include <cstdlib>
#include <filesystem>

namespace panoptic::test {

inline std::filesystem::path shared_folder() {
  if (const char* folder = std::getenv("PANOPTIC_SHARED")) return folder;
  return source_folder() / ".." / "shared";
}

}  // namespace panoptic::test

// Ends the test as skipped, saying why, where the file or folder is absent. In CI they are there and the test runs.
#define PANOPTIC_REQUIRE_SHARED(relative)                                       \
  if (!std::filesystem::exists(::panoptic::test::shared_folder() / (relative))) \
  GTEST_SKIP() << "needs " << (::panoptic::test::shared_folder() / (relative)) << "; set PANOPTIC_SHARED to its folder"
