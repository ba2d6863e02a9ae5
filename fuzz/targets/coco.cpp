// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predict/coco_panoptic.h"

#include <algorithm>

#include "fuzz/input.h"

namespace panoptic::fuzz {
namespace {

void read(const std::filesystem::path& json, const std::optional<LabelSet>& labels) {
  constexpr std::size_t kMostFrames = 4;
  std::size_t frames = 0;
  const CocoPanoptic coco = read_coco_panoptic(json, labels);
  for (const auto& [frame, picture] : coco.pictures) {
    if (++frames > kMostFrames) break;
    succeeds([&, number = frame] {
      const Segmentation segmentation = read_coco_frame(coco, number);
      const Image<std::uint16_t>& image = segmentation.segment_at;
      require(check(segmentation, image.width(), image.height()).used, "what was read can be used");
    });
  }
}

}  // namespace

// The JSON file and the pictures 0.png and 1.png beside it.
void coco(Input input) {
  static const Scratch kScratch("coco");
  static const LabelSet kLabels = load_label_set("indoor");
  const std::vector<Input> parts = parts_of(input, 3);
  const std::filesystem::path json = kScratch.put("panoptic.json", parts[0]);
  for (std::size_t i = 1; i < 3; ++i) kScratch.put(i == 1 ? "0.png" : "1.png", i < parts.size() ? parts[i] : Input{});
  succeeds([&] { read(json, std::nullopt); });
  succeeds([&] { read(json, kLabels); });
}

}  // namespace panoptic::fuzz
