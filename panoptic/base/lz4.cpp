// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The one source that knows liblz4.
#include <lz4frame.h>

#include <memory>
#include <new>

#include "panoptic/base/unpacking.h"

namespace panoptic {

UnpackedBytes unpacked_lz4(PackedBytes packed, std::size_t size) {
  LZ4F_dctx* made = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&made, LZ4F_VERSION)) != 0) throw std::bad_alloc();
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(made, &LZ4F_freeDecompressionContext);
  return unpacked_in_steps(packed.size(), size, [&](std::span<std::uint8_t> to, std::size_t& filled) {
    std::size_t taken = packed.size();
    filled = to.size();
    const std::size_t left = LZ4F_decompress(context.get(), to.data(), &filled, packed.data(), &taken, nullptr);
    if (LZ4F_isError(left) != 0) {
      filled = 0;
      return Unpacking::kDamaged;
    }
    packed = packed.subspan(taken);
    if (left == 0) return Unpacking::kDone;
    return taken == 0 && filled == 0 ? Unpacking::kDamaged : Unpacking::kGoesOn;
  });
}

}  // namespace panoptic
