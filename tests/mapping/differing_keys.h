// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <set>
#include <string>

#include "panoptic/options.h"

#include "panoptic/base/config.h"
#include "panoptic/mapping/option_fields.h"

namespace panoptic::test {

// The options whose values differ, by the text of both.
inline std::set<std::string> differing_keys(Options a, Options b) {
  std::set<std::string> keys;
  const Fields left = fields(a);
  const Fields right = fields(b);
  for (std::size_t i = 0; i < left.size(); ++i) {
    if (to_toml({left[i]}) != to_toml({right[i]})) keys.insert(left[i].key);
  }
  return keys;
}

}  // namespace panoptic::test
