// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The pixels of image messages. All throw Error (an unknown encoding by its name; too few bytes for the size that is claimed).
#pragma once

#include <string_view>

#include "panoptic/bags/messages.h"
#include "panoptic/base/depth_image.h"
#include "panoptic/image.h"

namespace panoptic {

enum class ImageKind { kDepth, kColor, kGrey, kUnknown };

// By the encoding ("16UC1", "rgb8"), and by the topic's name where 16 bits of grey may be either.
ImageKind kind_of_encoding(std::string_view encoding, std::string_view topic);
// By the format of a compressed image: "16UC1; compressedDepth png", "rgb8; jpeg compressed bgr8", "jpeg".
ImageKind kind_of_format(std::string_view format, std::string_view topic);

// Whole numbers (16UC1, mono16: millimetres) or metres (32FC1), as they are stored.
DepthImage depth_of(const ImageMessage& image);
DepthImage depth_of(const CompressedImageMessage& image);

// rgb8, bgr8, rgba8, bgra8, 8UC3 and 8UC4 (blue first, as OpenCV has them), mono8, 8UC1.
Image<Rgb> color_of(const ImageMessage& image);
Image<Rgb> color_of(const CompressedImageMessage& image);

}  // namespace panoptic
