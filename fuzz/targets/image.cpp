// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "fuzz/input.h"
#include "panoptic/base/depth_image.h"
#include "panoptic/base/image_io.h"

namespace panoptic::fuzz {

void image(Input input) {
  static const Scratch kScratch("image");
  succeeds([&] { require(!decode_rgb(input, "input").empty(), "what was read has pixels"); });
  succeeds([&] { require(!decode_gray16(input, "input").empty(), "what was read has pixels"); });
  succeeds([&] {
    const bool empty = std::visit([](const auto& depth) { return depth.empty(); }, decode_depth_image(input, "input"));
    require(!empty, "what was read has pixels");
  });
  if (!text_of(input).starts_with("II") && !text_of(input).starts_with("MM")) return;
  const std::filesystem::path path = kScratch.put("a.tiff", input);
  succeeds([&] { require(!read_gray_float(path).empty(), "what was read has pixels"); });
}

}  // namespace panoptic::fuzz
