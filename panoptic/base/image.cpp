// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/image.h"

#include <fmt/format.h>

#include <cstdlib>

namespace panoptic {

void check_pixels(const void* pixels, int rows, std::ptrdiff_t row_bytes, std::ptrdiff_t length_bytes, std::size_t alignment) {
  if (rows < 0 || length_bytes < 0) throw Error("image: its size is below zero");
  if (rows == 0 || length_bytes == 0) return;
  if (pixels == nullptr) throw Error("image: it has a size but no pixels");
  if (std::abs(row_bytes) < length_bytes) {
    throw Error(
        fmt::format("image: its rows overlap: they begin {} bytes apart, and each has {} bytes", row_bytes, length_bytes));
  }
  if (reinterpret_cast<std::uintptr_t>(pixels) % alignment != 0 || row_bytes % static_cast<std::ptrdiff_t>(alignment) != 0) {
    throw Error(fmt::format("image: its pixels do not lie at multiples of {} bytes; copy it", alignment));
  }
}

}  // namespace panoptic
