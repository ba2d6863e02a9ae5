// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Colours between two others, for the pictures of plans.
#pragma once

#include <cmath>
#include <cstdint>

#include "panoptic/image.h"

namespace panoptic {

// `share` 0 is a, 1 is b.
inline Rgb mixed(const Rgb& a, const Rgb& b, double share) {
  const auto mix = [&](std::uint8_t x, std::uint8_t y) { return static_cast<std::uint8_t>(std::lround(x + share * (y - x))); };
  return {mix(a.r, b.r), mix(a.g, b.g), mix(a.b, b.b)};
}

}  // namespace panoptic
