// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace panoptic {

// The corner (0, 1, 2) that speaks for a triangle whose corners bear labels a, b, c: one of the majority, else the first.
template <typename Label>
constexpr int speaker(Label a, Label b, Label c) {
  return a != b && b == c ? 1 : 0;
}

}  // namespace panoptic
