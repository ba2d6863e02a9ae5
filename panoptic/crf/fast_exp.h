// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// e^x for loops that must vectorise and give the same bits everywhere, which the library's expf promises neither of.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>

#include "panoptic/base/lanes.h"

namespace panoptic {

// Within 2e-7 relative down to x = -87; below that e^-87, which is 1e-38. REQUIRES x <= 0 and not NaN.
[[gnu::always_inline]] inline float fast_exp(float x) {
  constexpr float kLog2E = 1.44269504F;
  constexpr float kLn2High = 0.693359375F;  // ln 2 in two parts: the first has so few bits that n times it is exact
  constexpr float kLn2Low = -2.12194440e-4F;
  const float held = x > -87.0F ? x : -87.0F;
  const auto n = static_cast<std::int32_t>(held * kLog2E - 0.5F);
  const auto whole = static_cast<float>(n);
  const float r = held - whole * kLn2High - whole * kLn2Low;  // |r| <= ln 2 / 2
  float p = 1.0F / 720;
  p = p * r + 1.0F / 120;
  p = p * r + 1.0F / 24;
  p = p * r + 1.0F / 6;
  p = p * r + 0.5F;
  p = p * r + 1.0F;
  p = p * r + 1.0F;
  return p * std::bit_cast<float>((n + 127) << 23);
}

// The same bits, eight or sixteen at once.
template <typename Part>
[[gnu::always_inline]] inline void fast_exp(Part& x) {
  using Integers [[gnu::vector_size(sizeof(Part))]] = std::int32_t;
  constexpr float kLog2E = 1.44269504F;
  const Part lowest = Part{} - 87.0F;
  const Part held = x > lowest ? x : lowest;
  const Integers n = __builtin_convertvector(held * kLog2E - 0.5F, Integers);
  const Part whole = __builtin_convertvector(n, Part);
  const Part r = held - whole * 0.693359375F - whole * -2.12194440e-4F;
  Part p = Part{} + 1.0F / 720;
  p = p * r + 1.0F / 120;
  p = p * r + 1.0F / 24;
  p = p * r + 1.0F / 6;
  p = p * r + 0.5F;
  p = p * r + 1.0F;
  p = p * r + 1.0F;
  const Integers exponent = (n + 127) << 23;
  Part power;
  std::memcpy(&power, &exponent, sizeof power);
  x = p * power;
}

}  // namespace panoptic
