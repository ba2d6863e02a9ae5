// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The images of a frame, packed without loss, with the cameras that saw them: all that fusion needs of a frame but its pose.
// docs/map_format.md has the layout.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "panoptic/base/compression.h"
#include "panoptic/frame.h"

namespace panoptic {

// Whether an image of a log may be of that size: more is taken for damage.
bool may_be_image(std::uint32_t width, std::uint32_t height);

// REQUIRES that the frame can be used (check in frame.h).
Bytes pack_images(const Frame& frame);

// The same images and cameras, bit for bit; the rest of the frame is unset. Nothing if the bytes are damaged; memory is taken for
// no more than so many bytes can hold.
std::optional<Frame> unpack_images(std::span<const std::uint8_t> bytes);

}  // namespace panoptic
