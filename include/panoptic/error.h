// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The four kinds of trouble:
//   the world is wrong (file, option, model)  throw Error, from the edges and from set-up only;
//   something is not used (a frame)           an Outcome with the reason (outcome.h): mapping goes on without it;
//   nothing there                             optional or nullptr;
//   the code is wrong                         PANOPTIC_ASSERT (checked in the dev, asan and tsan presets).
// REQUIRES in a comment is the duty of the caller: whoever neglects it makes trouble of the last kind, which a release build does
// not notice.
#pragma once

#include <stdexcept>
#include <string>

namespace panoptic {

// One line for a person: what is wrong, where, what to do. Line breaks and other control characters in the message (file
// names and values may hold them) become spaces.
class Error : public std::runtime_error {
 public:
  explicit Error(std::string message);
};

[[noreturn]] void assertion_failed(const char* condition, const char* file, int line);

}  // namespace panoptic

#ifdef PANOPTIC_ASSERTIONS
#define PANOPTIC_ASSERT(condition) ((condition) ? void(0) : ::panoptic::assertion_failed(#condition, __FILE__, __LINE__))
#else
#define PANOPTIC_ASSERT(condition) void(0)
#endif
