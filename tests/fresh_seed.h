// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Tests too long to try everything try a part, and another part each time.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <random>

namespace panoptic::test {

// Another at each call, and printed; PANOPTIC_SEED repeats one.
inline std::uint32_t fresh_seed() {
  const char* chosen = std::getenv("PANOPTIC_SEED");
  const std::uint32_t seed =
      chosen == nullptr ? std::random_device()() : static_cast<std::uint32_t>(std::strtoul(chosen, nullptr, 10));
  std::printf("PANOPTIC_SEED=%u tries the same again\n", seed);
  std::fflush(stdout);
  return seed;
}

}  // namespace panoptic::test
