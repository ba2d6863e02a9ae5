// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Procedural textures for parametric furniture. The same arguments give the same pixels.
#pragma once

#include <cstdint>

#include "panoptic/image.h"

namespace panoptic {

Image<Rgb> paint_wood(Rgb color, std::uint64_t seed);   // grain along v; repeats
Image<Rgb> paint_cloth(Rgb color, int variant);         // plain, stripes, dots or bands; repeats
Image<Rgb> paint_stone(Rgb color, std::uint64_t seed);  // speckles; repeats
Image<Rgb> paint_picture(int variant);                  // landscapes, blocks, discs and waves
Image<Rgb> paint_sky(std::uint64_t seed);               // what a window pane shows: bright, with a horizon
Image<Rgb> paint_books(std::uint64_t seed, int books);  // a row of spines
Image<Rgb> paint_screen(int variant);                   // a dark screen, or one with windows on it

}  // namespace panoptic
