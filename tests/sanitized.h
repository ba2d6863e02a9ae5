// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Whether a sanitizer watches: memory is then another, and time is ten times as long.
#pragma once

#include <algorithm>
#include <vector>

#include "tests/fresh_seed.h"

namespace panoptic::test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

// All of them, or under a sanitizer a third by chance, one at least.
template <typename T>
std::vector<T> third_under_a_sanitizer(std::vector<T> all) {
  if (!kSanitized) return all;
  std::mt19937 random(fresh_seed());
  std::shuffle(all.begin(), all.end(), random);
  all.resize((all.size() + 2) / 3);
  return all;
}

}  // namespace panoptic::test
