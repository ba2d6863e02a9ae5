// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Random numbers of a known algorithm (splitmix64), so that a seed means the same on every machine and with every compiler: the
// distributions of <random> do not promise that. A stream is (seed, purpose, counter): to draw for frame 12 alone, make
// Random(seed, kPurpose, 12). Not for secrets.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "panoptic/error.h"

namespace panoptic {

// All 64 bits of the result depend on all bits of the argument; a bijection (the finaliser of splitmix64).
constexpr std::uint64_t mix_bits(std::uint64_t bits) {
  bits += 0x9e3779b97f4a7c15U;
  bits = (bits ^ (bits >> 30U)) * 0xbf58476d1ce4e5b9U;
  bits = (bits ^ (bits >> 27U)) * 0x94d049bb133111ebU;
  return bits ^ (bits >> 31U);
}

// The same three numbers give the same bits.
constexpr std::uint64_t hash_bits(std::uint64_t seed, std::uint64_t a, std::uint64_t b = 0) {
  return mix_bits(mix_bits(mix_bits(seed) ^ a) ^ b);
}

// The upper 53 bits as a number in [0, 1).
constexpr double unit_interval(std::uint64_t bits) { return static_cast<double>(bits >> 11U) * 0x1p-53; }

class Random {
 public:
  explicit Random(std::uint64_t seed, std::uint64_t purpose = 0, std::uint64_t counter = 0)
      : state_(hash_bits(seed, purpose, counter)) {}

  std::uint64_t bits() {
    state_ += 0x9e3779b97f4a7c15U;
    return mix_bits(state_);
  }

  double uniform() { return unit_interval(bits()); }  // [0, 1)
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  bool chance(double probability) { return uniform() < probability; }

  // 0 .. count - 1. REQUIRES count > 0. The bias is below count / 2^53.
  std::size_t index(std::size_t count) {
    PANOPTIC_ASSERT(count > 0);
    return static_cast<std::size_t>(uniform() * static_cast<double>(count));
  }
  int integer(int low, int high) {
    return low + static_cast<int>(index(static_cast<std::size_t>(high - low + 1)));
  }  // both included

  // Standard normal (Box and Muller; the second value is dropped, so that every call takes two numbers).
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
  }

  template <typename T>
  const T& pick(const std::vector<T>& choices) {
    return choices[index(choices.size())];
  }

  template <typename T>
  void shuffle(std::vector<T>& items) {
    for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[index(i)]);
  }

 private:
  std::uint64_t state_;
};

}  // namespace panoptic
