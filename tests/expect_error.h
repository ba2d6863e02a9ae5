// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The complaint of an action: EXPECT_THAT(error_of([&] { read_file(path); }), HasSubstr("cannot read")).
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "panoptic/error.h"

namespace panoptic::test {

// The message of the Error that the action throws; fails the test if it throws none or one of several lines.
inline std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    std::string message = error.what();
    EXPECT_EQ(message.find('\n'), std::string::npos) << "an error is one line: " << message;
    EXPECT_FALSE(message.empty());
    return message;
  }
  ADD_FAILURE() << "expected an Error";
  return "";
}

}  // namespace panoptic::test
