// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Depth images as people store them. Errors and limits are those of image_io.h.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <variant>

#include "panoptic/image.h"

namespace panoptic {

// Whole numbers, or floats: the values as they are stored.
using DepthImage = std::variant<Image<std::uint16_t>, Image<float>>;

// By the first bytes: PNG, PGM or TIFF with one channel of 16 bits; TIFF with one of 32-bit floats; a NumPy array of two
// dimensions; OpenEXR in scan lines, of which the channel Z (or Depth, Y, R, or the only one) counts. Whole numbers of 32 or 64
// bits that fit are narrowed, negative ones become 0. Throws Error for everything else, 8 bits above all, with what was found.
DepthImage read_depth_image(const std::filesystem::path& path);
DepthImage decode_depth_image(std::span<const std::uint8_t> bytes, std::string_view name);

}  // namespace panoptic
