// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Loops over pixels that Python hands over. They know nothing of Python, and are compiled apart with all optimisations of the
// library, since they run once a pixel. Another thread may write to the pixels meanwhile: what decides where something is read
// or written is looked at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "panoptic/image.h"
#include "panoptic/segmentation.h"

namespace panoptic::python {

// Whole numbers wherever they lie: those of pixel (u, v) are at first + v * row_bytes + u * pixel_bytes, as this machine writes
// them.
struct WholeNumbers {
  const char* first = nullptr;
  std::ptrdiff_t row_bytes = 0;
  std::ptrdiff_t pixel_bytes = 0;
  int width = 0;
  int height = 0;
  int bytes = 1;  // of a number: 1, 2, 4 or 8
  bool is_signed = false;
};

// Says what a number other than 0 means. It is asked for every number that occurs, some more than once.
using Meaning = std::function<std::uint16_t(std::int64_t)>;

// The meaning of each pixel; 0 of 0. T: std::uint16_t or ClassId. Throws what `meaning` throws.
template <typename T>
Image<T> translated(const WholeNumbers& numbers, const Meaning& meaning);

// The pixels of a mask that are not 0, in their box, as an instance of no class; an empty image if there are none.
Instance cut_out(const ImageView<std::uint8_t>& mask);

// Gives the instance's class to its pixels that have none.
void paint(const Instance& instance, Image<ClassId>& semantic);

Image<float> in_metres(const ImageView<std::uint16_t>& raw, float metres_per_unit);

}  // namespace panoptic::python
