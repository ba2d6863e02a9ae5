// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/os.h"

#include <gtest/gtest.h>

#include <cerrno>

#include "panoptic/base/files.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

using test::fresh_folder;

TEST(Os, WhatDoesNotOpenHasNoStatusAndKeepsTheReason) {
  const os::File file = os::open_to_read(fresh_folder("os") / "absent");
  EXPECT_FALSE(file.is_open());
  EXPECT_FALSE(file.status().has_value());
  EXPECT_EQ(errno, ENOENT);
}

TEST(Os, AReadEndsWhereTheFileEnds) {
  const auto path = fresh_folder("os") / "file";
  write_file(path, "abcdef");
  const os::File file = os::open_to_read(path);
  std::string bytes(10, '-');
  EXPECT_EQ(file.read(2, bytes.data(), bytes.size()), 4U);
  EXPECT_EQ(bytes, "cdef------");
  EXPECT_EQ(file.read(100, bytes.data(), bytes.size()), 0U);
  EXPECT_EQ(file.status()->size, 6U);
}

TEST(Os, ALockIsHeldByOneUntilItIsClosed) {
  const auto path = fresh_folder("os") / "file";
  write_file(path, "abc");
  os::File first = os::open_to_read(path);
  const os::File second = os::open_to_read(path);
  ASSERT_EQ(first.status()->id, second.status()->id);
  EXPECT_TRUE(first.lock());
  EXPECT_FALSE(second.lock());
  EXPECT_EQ(errno, EWOULDBLOCK);
  EXPECT_TRUE(first.close());
  EXPECT_TRUE(second.lock());
}

TEST(Os, WhatIsMappedOfAFileWithoutANameComesBackAfterItsMemoryWasGivenBack) {
  const auto folder = fresh_folder("os");
  const os::File file = os::open_without_name(folder);
  ASSERT_TRUE(file.is_open());
  EXPECT_TRUE(names_in_folder(folder).empty());
  constexpr std::size_t kBytes = 1 << 16;
  ASSERT_TRUE(file.take_space(0, kBytes));
  auto* const memory = static_cast<char*>(file.map(0, kBytes, 4096));
  ASSERT_NE(memory, nullptr);
  memory[kBytes - 1] = 'x';
  os::give_back(memory, kBytes);
  EXPECT_EQ(memory[kBytes - 1], 'x');
  os::unmap(memory, kBytes);
}

}  // namespace
}  // namespace panoptic
