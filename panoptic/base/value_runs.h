// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Runs of equal values in a row of an image, or in the labels of a brick.
#pragma once

#include <cstdint>

namespace panoptic {

// The end of the run of equal values that begins at `begin`; long runs are passed over many values at a time.
inline int end_of_run(const std::uint16_t* row, int begin, int width) {
  constexpr int kAtOnce = 32;
  int end = begin + 1;
  for (; end + kAtOnce <= width; end += kAtOnce) {
    std::uint16_t differ = 0;
    for (int k = 0; k < kAtOnce; ++k) differ |= static_cast<std::uint16_t>(row[end + k] ^ row[begin]);
    if (differ != 0) break;
  }
  while (end < width && row[end] == row[begin]) ++end;
  return end;
}

}  // namespace panoptic
