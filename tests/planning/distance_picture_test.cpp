// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A level slice through distances, to look at.
#include "panoptic/planning/distance_picture.h"

#include <gmock/gmock.h>

#include <limits>

#include "panoptic/base/image_io.h"

namespace panoptic {
namespace {

constexpr float kUnknown_m = std::numeric_limits<float>::quiet_NaN();
constexpr double kCap_m = 2;

// Two levels of 3 x 2 cells; the lower one is `lower_m`, x fastest.
DistanceField::Values two_levels(const std::vector<float>& lower_m) {
  DistanceField::Values values{{3, 2, 2}, Vec3d::Zero(), lower_m};
  values.distance_m.insert(values.distance_m.end(), lower_m.size(), static_cast<float>(kCap_m));
  return values;
}

struct Picture {
  explicit Picture(const std::vector<std::uint8_t>& png) : pixels(decode_rgb(png, "slice")) {}
  // The pixel of the cell (x of 3, y of 2) that is farthest from the middle of the picture. North is up.
  Rgb at(int x, int y) const { return pixels(x == 0 ? 0 : (x + 1) * kSlicePixelsPerCell - 1, y == 0 ? pixels.height() - 1 : 0); }
  Image<Rgb> pixels;
};

TEST(DistancePicture, IsRedAtSurfacesBlueFarAwayAndGreyBehind) {
  const Picture picture(distance_slice_png(two_levels({0, 0, 0, -0.1F, -0.1F, -0.1F}), kCap_m, 0));
  EXPECT_EQ(picture.pixels.width(), 3 * kSlicePixelsPerCell);
  EXPECT_EQ(picture.pixels.height(), 2 * kSlicePixelsPerCell);
  EXPECT_GT(picture.at(1, 0).r, 2 * picture.at(1, 0).b);
  EXPECT_EQ(picture.at(1, 1).r, picture.at(1, 1).g);
  const Picture far(distance_slice_png(two_levels({0, 0, 0, 0, 0, 0}), kCap_m, 1));
  EXPECT_GT(far.at(1, 0).b, 2 * far.at(1, 0).r);
}

TEST(DistancePicture, NorthIsUpAndEastIsRight) {
  const Picture picture(distance_slice_png(two_levels({2, 2, 2, 2, 2, 0}), kCap_m, 0));
  EXPECT_GT(picture.at(2, 1).r, picture.at(2, 1).b);
  EXPECT_LT(picture.at(0, 1).r, picture.at(0, 1).b);
  EXPECT_LT(picture.at(0, 0).r, picture.at(0, 0).b);
}

TEST(DistancePicture, LinesRunAtEveryQuarterOfAMetre) {
  // Distances grow along x: .1, .2, .3 m; one line, between the second and the third cell, in both rows.
  const Picture picture(distance_slice_png(two_levels({0.1F, 0.2F, 0.3F, 0.1F, 0.2F, 0.3F}), kCap_m, 0));
  int dark = 0;
  for (int v = 0; v < picture.pixels.height(); ++v) {
    for (int u = 0; u < picture.pixels.width(); ++u) dark += picture.pixels(u, v).r < 170;
  }
  EXPECT_EQ(dark, picture.pixels.height());
}

TEST(DistancePicture, UnknownCellsAreSeeThroughAndTakeNothingFromTheirNeighbours) {
  const Picture beside(distance_slice_png(two_levels({0, kUnknown_m, 0, 0, 0, 0}), kCap_m, 0));
  const Rgb next_to_it = beside.pixels(kSlicePixelsPerCell - 1, beside.pixels.height() - 1);
  EXPECT_GT(next_to_it.r, 2 * next_to_it.b);
  // Unknown cells have the grey of those behind surfaces, but are see-through.
  const std::vector<float> behind(6, -0.1F);
  const std::vector<float> unknown(6, kUnknown_m);
  EXPECT_NE(distance_slice_png(two_levels(behind), kCap_m, 0), distance_slice_png(two_levels(unknown), kCap_m, 0));
}

}  // namespace
}  // namespace panoptic
