// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Words and boxes in pictures: the one seam to OpenCV's drawing. What lies outside the image is cut off.
#pragma once

#include <string>

#include "panoptic/image.h"
#include "panoptic/objects.h"

namespace panoptic {

struct TextSize {
  int width_px = 0;
  int height_px = 0;  // of the capitals
};

TextSize text_size(const std::string& text, double scale);

// Draws the text, smoothed, with the lower left corner of its first letter at (u, v).
void draw_text(Image<Rgb>& image, const std::string& text, int u, int v, const Rgb& color, double scale);

void fill(Image<Rgb>& image, const PixelBox& box, const Rgb& color, double opacity = 1);

}  // namespace panoptic
