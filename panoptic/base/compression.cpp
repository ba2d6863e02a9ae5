// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/compression.h"

#include <zstd.h>

#include <memory>
#include <new>
#include <string>

#include "panoptic/base/unpacking.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr int kLevel = 1;  // most bytes are noise of the sensor: higher levels take longer and gain half a percent
// Noise: repetitions are looked for at every 200th byte, and the bytes still packed by how frequent they are (ZSTD_ps_enable
// of ZSTD_c_literalCompressionMode, which zstd.h has under this name), as they would not be at such a level.
constexpr int kNoiseLevel = -200;
constexpr ZSTD_cParameter kByFrequency = ZSTD_c_experimentalParam5;

}  // namespace

std::uint64_t checksum(std::span<const std::uint8_t> bytes, std::uint64_t before) {
  constexpr std::uint64_t kPrime = 0x100000001B3U;
  for (const std::uint8_t byte : bytes) before = (before ^ byte) * kPrime;
  return before;
}

struct Compressor::State {
  ZSTD_CCtx* context = ZSTD_createCCtx();
};

Compressor::Compressor(Contents contents) : state_(std::make_unique<State>()) {
  if (state_->context == nullptr) throw std::bad_alloc();
  const bool noise = contents == Contents::kNoise;
  ZSTD_CCtx_setParameter(state_->context, ZSTD_c_compressionLevel, noise ? kNoiseLevel : kLevel);
  if (noise) ZSTD_CCtx_setParameter(state_->context, kByFrequency, 1);
}

Compressor::~Compressor() { ZSTD_freeCCtx(state_->context); }

Bytes Compressor::compress(std::span<const std::span<const std::uint8_t>> parts) {
  std::size_t size = 0;
  std::size_t bound = 0;
  for (const auto& part : parts) {
    size += part.size();
    bound += ZSTD_compressBound(part.size()) + 16;  // headers of the parts' own blocks
  }
  ZSTD_CCtx_reset(state_->context, ZSTD_reset_session_only);
  ZSTD_CCtx_setPledgedSrcSize(state_->context, size);
  bound += 32;
  const auto frame = std::make_unique_for_overwrite<std::uint8_t[]>(bound);
  ZSTD_outBuffer out{frame.get(), bound, 0};
  for (std::size_t i = 0; i < parts.size(); ++i) {
    ZSTD_inBuffer in{parts[i].data(), parts[i].size(), 0};
    const ZSTD_EndDirective then = i + 1 == parts.size() ? ZSTD_e_end : ZSTD_e_flush;
    const std::size_t left = ZSTD_compressStream2(state_->context, &out, &in, then);
    if (ZSTD_isError(left) != 0 || left != 0) throw Error("compression failed: " + std::string(ZSTD_getErrorName(left)));
  }
  return {frame.get(), frame.get() + out.pos};
}

struct Decompressor::State {
  ZSTD_DCtx* context = ZSTD_createDCtx();
};

Decompressor::Decompressor() : state_(std::make_unique<State>()) {
  if (state_->context == nullptr) throw std::bad_alloc();
}

Decompressor::~Decompressor() { ZSTD_freeDCtx(state_->context); }

std::size_t Decompressor::decompress(std::span<const std::uint8_t> frame, std::span<std::uint8_t> to) {
  const std::size_t size = ZSTD_decompressDCtx(state_->context, to.data(), to.size(), frame.data(), frame.size());
  return ZSTD_isError(size) != 0 ? kDamaged : size;
}

std::optional<std::size_t> zstd_size(PackedBytes packed) {
  const unsigned long long size = ZSTD_getFrameContentSize(packed.data(), packed.size());
  if (size == ZSTD_CONTENTSIZE_ERROR || size == ZSTD_CONTENTSIZE_UNKNOWN) return std::nullopt;
  return size;
}

UnpackedBytes unpacked_zstd(PackedBytes packed, std::size_t size) {
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(), &ZSTD_freeDCtx);
  if (context == nullptr) throw std::bad_alloc();
  constexpr int kMostWindow = 27;  // 128 MiB of working memory at most
  ZSTD_DCtx_setParameter(context.get(), ZSTD_d_windowLogMax, kMostWindow);
  ZSTD_inBuffer in{packed.data(), packed.size(), 0};
  return unpacked_in_steps(packed.size(), size, [&](std::span<std::uint8_t> to, std::size_t& filled) {
    const std::size_t before = in.pos;
    ZSTD_outBuffer out{to.data(), to.size(), 0};
    const std::size_t left = ZSTD_decompressStream(context.get(), &out, &in);
    if (ZSTD_isError(left) != 0) return Unpacking::kDamaged;
    filled = out.pos;
    if (left == 0 && in.pos == in.size) return Unpacking::kDone;
    return in.pos == before && filled == 0 ? Unpacking::kDamaged : Unpacking::kGoesOn;
  });
}

}  // namespace panoptic
