// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predict/preprocess.h"

#include <gtest/gtest.h>

#include "tests/base/foreign_memory.h"

namespace panoptic {
namespace {

Image<Rgb> numbered_image(int width, int height) {
  Image<Rgb> image(width, height);
  for (std::size_t i = 0; i < image.size(); ++i) {
    image[i] = {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(50 + i), static_cast<std::uint8_t>(255 - i)};
  }
  return image;
}

InputFormat format_of(int width, int height) {
  InputFormat format;
  format.width = width;
  format.height = height;
  return format;
}

TEST(ToInput, NormalizesEachChannelIntoItsOwnPlane) {
  const Image<Rgb> image = numbered_image(5, 3);
  InputFormat format = format_of(5, 3);
  format.scale = 0.5;
  format.mean = {1, 2, 3};
  format.std = {2, 4, 8};
  const Tensor tensor = to_input(image, format);
  ASSERT_EQ(tensor.shape, (std::vector<int>{1, 3, 3, 5}));
  for (std::size_t i = 0; i < image.size(); ++i) {
    EXPECT_FLOAT_EQ(tensor.values[i], (image[i].r * 0.5F - 1) / 2);
    EXPECT_FLOAT_EQ(tensor.values[15 + i], (image[i].g * 0.5F - 2) / 4);
    EXPECT_FLOAT_EQ(tensor.values[30 + i], (image[i].b * 0.5F - 3) / 8);
  }
}

TEST(ToInput, ReadsBorrowedRowsWhereverTheyLie) {
  const Image<Rgb> image = numbered_image(7, 5);
  for (const test::RowOrder order : {test::RowOrder::kTopFirst, test::RowOrder::kTopLast}) {
    const test::ForeignMemory<Rgb> memory(image, 11, order);
    for (const int size : {5, 8}) {  // one that is resized to, and one that is not
      EXPECT_EQ(to_input(memory.view(), format_of(7, size)).values, to_input(image, format_of(7, size)).values);
    }
  }
}

TEST(ToInput, SwapsChannelsForBgrNetworks) {
  const Image<Rgb> image = numbered_image(2, 2);
  InputFormat format = format_of(2, 2);
  format.channels = "bgr";
  const Tensor tensor = to_input(image, format);
  EXPECT_FLOAT_EQ(tensor.values[0], image[0].b / 255.0F);
  EXPECT_FLOAT_EQ(tensor.values[8], image[0].r / 255.0F);
}

TEST(ToInput, KeepsTheAspectInALetterbox) {
  InputFormat format = format_of(8, 8);
  format.resize = "letterbox";
  format.pad_value = 114;
  const Tensor tensor = to_input(Image<Rgb>(4, 2, Rgb{200, 200, 200}), format);
  for (std::size_t i = 0; i < 64; ++i) EXPECT_FLOAT_EQ(tensor.values[i], (i < 32 ? 200 : 114) / 255.0F) << i;
  const Placement placement = place(4, 2, format);
  EXPECT_DOUBLE_EQ(placement.scale_x, 2);
  EXPECT_DOUBLE_EQ(placement.scale_y, 2);
}

TEST(ToInput, StretchesToTheWholeInput) {
  const Tensor tensor = to_input(Image<Rgb>(4, 2, Rgb{200, 200, 200}), format_of(8, 8));
  for (const float value : tensor.values) EXPECT_FLOAT_EQ(value, 200 / 255.0F);
  const Placement placement = place(4, 2, format_of(8, 8));
  EXPECT_DOUBLE_EQ(placement.scale_x, 2);
  EXPECT_DOUBLE_EQ(placement.scale_y, 4);
}

TEST(ToInput, TakesExtremelyNarrowImages) {
  InputFormat format = format_of(8, 8);
  format.resize = "letterbox";
  EXPECT_EQ(to_input(Image<Rgb>(1000, 1), format).values.size(), 192U);
  EXPECT_EQ(to_input(Image<Rgb>(1, 1000), format).values.size(), 192U);
}

}  // namespace
}  // namespace panoptic
