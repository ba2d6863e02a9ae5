// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Textures of walls and floors: pictures that repeat without a seam, each of which covers kTextureSide_m.
#pragma once

#include <cstdint>

#include "panoptic/image.h"

namespace panoptic {

constexpr double kTextureSide_m = 2.0;

enum class SurfaceFinish : std::uint8_t { kPlaster, kStripes, kPlanks, kTiles, kCarpet };

// 512 x 512 pixels. The colour is the surface's mean; the seed varies grain, planks and tiles.
Image<Rgb> surface_texture(SurfaceFinish surface, const Rgb& color, std::uint64_t seed);

}  // namespace panoptic
