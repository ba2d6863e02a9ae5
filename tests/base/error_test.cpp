// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/error.h"

#include <gtest/gtest.h>

namespace panoptic {
namespace {

TEST(Error, IsOneLineWhateverTheFileNameHolds) {
  EXPECT_STREQ(Error("cannot read a\nb\r\x1b[31m\x7f: no").what(), "cannot read a b  [31m : no");
}

TEST(Error, KeepsOtherLetters) { EXPECT_STREQ(Error("Küche/目.toml:3").what(), "Küche/目.toml:3"); }

#ifdef PANOPTIC_ASSERTIONS
TEST(AssertDeathTest, NamesTheConditionAndThePlace) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_DEATH(PANOPTIC_ASSERT(1 + 1 == 3), "error_test.cpp:[0-9]+: assertion failed: 1 \\+ 1 == 3");
}
#endif

}  // namespace
}  // namespace panoptic
