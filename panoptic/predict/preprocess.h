// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Turns a colour image into a network's input tensor, and says where the image lies in it.
#pragma once

#include "panoptic/image.h"
#include "panoptic/predict/model.h"

namespace panoptic {

// The image's top left corner is the input's; pixel centres lie half a pixel inside, in both:
// input = (image + 0.5) * scale - 0.5.
struct Placement {
  int image_width = 0;
  int image_height = 0;
  int input_width = 0;
  int input_height = 0;
  double scale_x = 1;  // input pixels per image pixel
  double scale_y = 1;
};

Placement place(int image_width, int image_height, const InputFormat& format);

// The input tensor, 1 x 3 x height x width. The image must not be empty.
Tensor to_input(const ImageView<Rgb>& image, const InputFormat& format);

}  // namespace panoptic
