// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Writes the frames of recordings.h as the apps of phones and their tools store them.
#pragma once

#include <filesystem>
#include <string>

#include "tests/io/recordings.h"

namespace panoptic::test {

// The levels of a frame's readings: 0 in the first row, 1 in the second, 2 in all others.
Image<std::uint8_t> confidence_image(ImageSize size = kDepthSize);
void write_confidence(const std::filesystem::path& path, const Image<std::uint8_t>& image);

// The camera of one frame where each has its own.
Camera own_camera(int i);

// ARKitScenes: images at 10.0, 10.1, ... s.
void write_arkitscenes(const std::filesystem::path& root);

// The matrix of the colour images, and that of a frame where each has its own.
Camera stray_camera(int i = 0);

// Stray Scanner: extracted images or none, and no column of intrinsics, unless wanted.
struct StrayKind {
  bool images = true;
  bool own_intrinsics = false;
  int first_image = 0;  // the number in its name
};
void write_stray(const std::filesystem::path& root, const StrayKind& kind = {});

// The point of the world that a pixel of a frame shows.
Vec3d seen_at(const Frame& frame, int u, int v);

// Frame i but for the confidence of its first row: depth of the others, pose, colour, and the given camera scaled to either
// image.
void expect_phone_frame(const ReadResult& result, int i, const Camera& camera, int color_tolerance = 0);

// Depth of one distance, `value`, as it is stored.
Image<std::uint16_t> flat_depth(std::uint16_t value, ImageSize size = kDepthSize);

}  // namespace panoptic::test
