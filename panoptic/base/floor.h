// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace panoptic {

// The largest integer not above the value. std::floor is a library call on CPUs of the x86-64 baseline; this is not.
// REQUIRES a value within the range of int32.
inline std::int32_t floor_to_int(float value) {
  const auto truncated = static_cast<std::int32_t>(value);
  return truncated - (value < static_cast<float>(truncated) ? 1 : 0);
}

}  // namespace panoptic
