// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Made-up pixels for tests of image files, and how damage to a file shows.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "panoptic/error.h"
#include "panoptic/image.h"

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

// Decodes copies of a sound file with each byte from `first` on changed in turn: every complaint begins with `start`, and nothing
// is printed.
inline void expect_quiet_complaints(const FileBytes& sound, std::size_t first, const std::string& start,
                                    const std::function<void(const FileBytes&)>& decode) {
  testing::internal::CaptureStderr();
  for (std::size_t i = first; i < sound.size(); ++i) {
    FileBytes damaged = sound;
    damaged[i] = static_cast<std::uint8_t>(damaged[i] ^ 0x55U);
    try {
      decode(damaged);
    } catch (const Error& error) {
      EXPECT_TRUE(std::string_view(error.what()).starts_with(start)) << i << ": " << error.what();
    }
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace panoptic::test
