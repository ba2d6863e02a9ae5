// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Made-up pixels for tests of image files, and what may or may not be complained about.
#pragma once

#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "panoptic/base/error.h"
#include "panoptic/base/image.h"

namespace panoptic::test {

using FileBytes = std::vector<std::uint8_t>;

inline FileBytes bytes_of_text(const std::string& text) { return {text.begin(), text.end()}; }

inline Image<Rgb> random_colors(int width, int height) {
  std::mt19937 random(11);
  Image<Rgb> image(width, height);
  for (std::size_t i = 0; i < image.size(); ++i) {
    image[i] = {static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random())};
  }
  return image;
}

inline Image<std::uint16_t> random_numbers(int width, int height, unsigned largest) {
  std::mt19937 random(12);
  Image<std::uint16_t> image(width, height);
  for (std::size_t i = 0; i < image.size(); ++i) image[i] = static_cast<std::uint16_t>(random() % (largest + 1));
  return image;
}

inline Image<Rgb> as_grey(const Image<std::uint16_t>& image, int shift) {
  Image<Rgb> grey(image.width(), image.height());
  for (std::size_t i = 0; i < image.size(); ++i) {
    const auto value = static_cast<std::uint8_t>(image[i] >> shift);
    grey[i] = {value, value, value};
  }
  return grey;
}

inline FileBytes samples_of(const Image<Rgb>& image) {
  FileBytes samples;
  for (const Rgb& c : image.pixels()) samples.insert(samples.end(), {c.r, c.g, c.b});
  return samples;
}

// The message of the Error that the action throws, if it does.
inline std::string complaint_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace panoptic::test
