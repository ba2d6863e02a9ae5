// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Checks of an image file before a codec sees it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace panoptic {

enum class ImageFormat : std::uint8_t { kPng, kJpeg, kTiff, kPnm, kNpy, kExr, kOther };

// The format by the first bytes; kPnm is PGM or PPM, as text or as bytes.
ImageFormat image_format(std::span<const std::uint8_t> bytes);

// Channels and bits as a PNG, PGM or PPM states them; zeros for anything else.
struct SampleKind {
  int channels = 0;
  int bits = 0;  // of a channel; those of a palette's colours
};
SampleKind sample_kind(std::span<const std::uint8_t> bytes);

// True for a PNG, JPEG, PGM, PPM or TIFF file by its first bytes whose header tells of at most max_pixels, and of no more than
// the best compression could pack into so many bytes, and which is not obviously cut off. Nothing else may reach the codecs:
// they take memory and time for whatever a header claims.
bool is_acceptable_image(std::span<const std::uint8_t> bytes, std::size_t max_pixels);

}  // namespace panoptic
