// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Numbers that look random and are the same each time.
#pragma once

#include <cstdint>

namespace panoptic {

// Knuth's linear congruential generator of 64 bits. Its upper bits are the better ones.
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : state_(seed) {}

  std::uint64_t next() { return state_ = state_ * 6364136223846793005ULL + 1442695040888963407ULL; }

 private:
  std::uint64_t state_;
};

}  // namespace panoptic
