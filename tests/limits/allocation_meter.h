// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// How much memory an action asks for, counted at malloc, so that libraries count too. One at a time.
#pragma once

#include <cstddef>
#include <functional>

namespace panoptic::test {

struct Allocations {
  std::size_t largest = 0;  // single request, bytes
  std::size_t peak = 0;     // bytes held at once, beyond what was held before
};

Allocations allocations_of(const std::function<void()>& action);

}  // namespace panoptic::test
