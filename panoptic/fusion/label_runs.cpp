// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/label_runs.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>

#include "panoptic/base/clones.h"

namespace panoptic {

namespace kernels {

constexpr std::size_t kFlags = 512;  // pixels on their way through the loops
struct RunFlags {
  alignas(64) std::array<std::uint8_t, kFlags> begins{};  // 1 where a pixel differs from the one before
};

void flag_changes(const std::uint16_t* segment, const LabelSlot* reference, std::size_t count, RunFlags& flags);

// Looks at one pixel before the first, too.
PANOPTIC_CLONES
void flag_changes(const std::uint16_t* segment, const LabelSlot* reference, std::size_t count, RunFlags& flags) {
  const std::uint16_t* __restrict s = segment;
  const LabelSlot* __restrict r = reference;
  std::uint8_t* __restrict begins = flags.begins.data();
  const std::uint16_t* s_before = s - 1;
  const LabelSlot* r_before = r - 1;
  for (std::size_t k = 0; k < count; ++k) {
    const bool differs = (s[k] != s_before[k]) | (number(r[k]) != number(r_before[k]));
    begins[k] = differs ? 1 : 0;
  }
}

}  // namespace kernels

void find_runs(std::span<const std::uint16_t> segment, std::span<const LabelSlot> reference, PixelRange pixels,
               std::vector<LabelRun>& runs) {
  runs.clear();
  const auto add = [&](std::size_t pixel) {
    runs.push_back({static_cast<std::uint32_t>(pixel), segment[pixel], reference[pixel]});
  };
  if (pixels.begin < pixels.end) add(pixels.begin);
  kernels::RunFlags flags;
  for (std::size_t first = pixels.begin + std::size_t{1}; first < pixels.end; first += kernels::kFlags) {
    const std::size_t count = std::min(kernels::kFlags, pixels.end - first);
    kernels::flag_changes(segment.data() + first, reference.data() + first, count, flags);
    std::fill(flags.begins.begin() + static_cast<std::ptrdiff_t>(count), flags.begins.end(), std::uint8_t{0});
    for (std::size_t k = 0; k < count; k += sizeof(std::uint64_t)) {
      std::uint64_t eight = 0;
      std::memcpy(&eight, flags.begins.data() + k, sizeof eight);
      for (; eight != 0; eight &= eight - 1) add(first + k + static_cast<std::size_t>(std::countr_zero(eight)) / 8);
    }
  }
  runs.push_back({pixels.end, 0, LabelSlot::kUnknown});
}

}  // namespace panoptic
