// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace panoptic::test {

// The least map.memory_limit_mb, as the refusal of a lower one names it.
inline int least_limit_mb(const std::string& refusal) {
  const std::string before = "set it to ";
  return std::stoi(refusal.substr(refusal.find(before) + before.size()));
}

}  // namespace panoptic::test
