// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// One target as libFuzzer calls it; the build says which.
#include <cstddef>

#include "fuzz/targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  panoptic::fuzz::PANOPTIC_FUZZ_TARGET({data, size});
  return 0;
}
