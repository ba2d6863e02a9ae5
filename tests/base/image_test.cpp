// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/image.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>

#include "tests/base/foreign_memory.h"
#include "tests/expect_error.h"

namespace panoptic {
namespace {

using test::error_of;
using test::ForeignMemory;
using test::RowOrder;
using testing::HasSubstr;

Image<Rgb> some_colors(int width, int height) {
  Image<Rgb> image(width, height);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) image(u, v) = {static_cast<std::uint8_t>(u), static_cast<std::uint8_t>(v), 7};
  }
  return image;
}

TEST(ImageView, ReadsPixelsWhereTheyLieWhateverTheDistanceOfRows) {
  const Image<Rgb> image = some_colors(5, 4);
  for (const RowOrder order : {RowOrder::kTopFirst, RowOrder::kTopLast}) {
    for (const std::size_t gap_bytes : {0U, 1U, 3U, 50U}) {
      const ForeignMemory<Rgb> memory(image, gap_bytes, order);
      const ImageView<Rgb> view = memory.view();
      EXPECT_EQ(view, image);
      EXPECT_EQ(view.copied(), image);
      EXPECT_EQ(view.is_dense(), gap_bytes == 0 && order == RowOrder::kTopFirst);
      for (std::size_t i = 0; i < image.size(); ++i) ASSERT_EQ(view[i], image[i]) << i;
    }
  }
}

TEST(ImageView, OfAnImageReadsItsPixelsAndSeesThemChange) {
  Image<Rgb> image = some_colors(5, 4);
  const ImageView<Rgb> view = image;
  EXPECT_EQ(view.row(0), image.data());
  image(2, 3) = {255, 0, 0};
  EXPECT_EQ(view(2, 3), (Rgb{255, 0, 0}));
}

TEST(ImageView, IsEqualOnlyIfSizeAndEveryPixelAre) {
  const Image<Rgb> image = some_colors(5, 4);
  for (std::size_t i = 0; i < image.size(); ++i) {
    Image<Rgb> other = image;
    other[i].b = 8;
    ASSERT_FALSE(ImageView<Rgb>(image) == ImageView<Rgb>(other)) << i;
  }
  EXPECT_FALSE(ImageView<Rgb>(image) == ImageView<Rgb>(some_colors(5, 3)));
  EXPECT_TRUE(ImageView<Rgb>() == ImageView<Rgb>(Image<Rgb>()));
}

TEST(ImageView, RefusesMemoryThatCannotHoldTheImage) {
  alignas(float) char bytes[64] = {};
  const auto* aligned = reinterpret_cast<const float*>(bytes);
  const auto* shifted = reinterpret_cast<const float*>(bytes + 1);
  const auto refusal = [](const float* pixels, int width, int height, std::ptrdiff_t row_bytes) {
    return error_of([&] { ImageView<float>(pixels, width, height, row_bytes); });
  };
  EXPECT_THAT(refusal(nullptr, 2, 2, 8), HasSubstr("no pixels"));
  EXPECT_THAT(refusal(aligned, -1, 2, 8), HasSubstr("below zero"));
  EXPECT_THAT(refusal(aligned, 3, 2, 3), HasSubstr("rows overlap: they begin 3 bytes apart, and each has 12 bytes"));
  EXPECT_THAT(refusal(aligned, 3, 2, -8), HasSubstr("rows overlap"));
  EXPECT_THAT(refusal(aligned, 3, 2, 14), HasSubstr("multiples of 4 bytes"));
  EXPECT_THAT(refusal(shifted, 3, 2, 12), HasSubstr("multiples of 4 bytes"));
  EXPECT_TRUE(ImageView<float>(nullptr, 0, 2, 0).empty());
  EXPECT_EQ(ImageView<float>(aligned, 3, 1, 0)(2, 0), 0) << "one row has no distance to the next";
}

TEST(SharedImage, TakesAnImageWithoutCopyingItsPixels) {
  Image<Rgb> image = some_colors(5, 4);
  const Rgb* pixels = image.data();
  const SharedImage<Rgb> shared = std::move(image);
  const SharedImage<Rgb> copy = shared;
  EXPECT_EQ(shared.row(0), pixels);
  EXPECT_EQ(copy.row(0), pixels);
  EXPECT_EQ(copy.kept().row(0), pixels);
}

TEST(SharedImage, LivesAsLongAsItsLastCopyAndKeepsTheOwnerAsLong) {
  auto memory = std::make_shared<const ForeignMemory<Rgb>>(some_colors(5, 4), 2);
  const std::weak_ptr<const void> is_there = memory;
  SharedImage<Rgb> shared(memory->view(), memory);
  memory.reset();
  SharedImage<Rgb> kept = shared.kept();
  EXPECT_EQ(kept.row(0), shared.row(0)) << "what has an owner is not copied";
  shared = {};
  EXPECT_FALSE(is_there.expired());
  EXPECT_EQ(kept, some_colors(5, 4));
  kept = {};
  EXPECT_TRUE(is_there.expired());
}

TEST(SharedImage, KeptIsACopyWhereNobodyOwnsThePixels) {
  SharedImage<Rgb> kept;
  {
    const ForeignMemory<Rgb> memory(some_colors(5, 4), 2);
    const SharedImage<Rgb> borrowed(memory.view());
    EXPECT_EQ(borrowed.row(0), memory.view().row(0));
    kept = borrowed.kept();
  }
  EXPECT_EQ(kept, some_colors(5, 4));
  EXPECT_TRUE(SharedImage<Rgb>().kept().empty());
}

}  // namespace
}  // namespace panoptic
