// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Image files in and out: the one seam to the codecs. Everything throws Error naming the file (absent, cut off, damaged,
// neither PNG, JPEG, PGM, PPM nor TIFF by its first bytes, more than 64 Mi pixels); writing is all or nothing.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "panoptic/image.h"

namespace panoptic {

// Grey or colour, any depth -> 8-bit RGB: of 16 bits the upper 8. Alpha is dropped, EXIF orientation ignored. Refused are JPEGs
// in CMYK or with damage of any kind, and TIFFs that are neither grey of 8 or 16 bits nor RGB of 8.
Image<Rgb> read_rgb(const std::filesystem::path& path);
// One channel of 16 or 8 bits (PNG, PGM, TIFF), values unchanged; a PNG of 1, 2 or 4 bits is stretched to 8.
Image<std::uint16_t> read_gray16(const std::filesystem::path& path);
// One channel of 32-bit floats (TIFF).
Image<float> read_gray_float(const std::filesystem::path& path);

// The same from bytes in memory; `name` is for the error text.
Image<Rgb> decode_rgb(std::span<const std::uint8_t> bytes, std::string_view name);
Image<std::uint16_t> decode_gray16(std::span<const std::uint8_t> bytes, std::string_view name);

// The bytes of such files. REQUIRES an image that is not empty. JPEG: quality 1..100.
std::vector<std::uint8_t> encode_jpeg(const ImageView<Rgb>& image, int quality);
std::vector<std::uint8_t> encode_png(const Image<std::uint8_t>& image);
std::vector<std::uint8_t> encode_png(const Image<std::uint16_t>& image);
// Colours with transparency; 0 = see-through. REQUIRES two images of one size.
std::vector<std::uint8_t> encode_png(const Image<Rgb>& color, const Image<std::uint8_t>& alpha);

void write_png(const std::filesystem::path& path, const Image<Rgb>& image);
void write_png(const std::filesystem::path& path, const Image<std::uint16_t>& image);

}  // namespace panoptic
