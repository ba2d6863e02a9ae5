// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "fuzz/input.h"
#include "panoptic/predict/prediction_io.h"

namespace panoptic::fuzz {

// predictions.json, 000000.json and 000000.png.
void predictions(Input input) {
  static const Scratch kScratch("predictions");
  constexpr std::string_view kNames[] = {"predictions.json", "000000.json", "000000.png"};
  const std::vector<Input> parts = parts_of(input, std::size(kNames));
  for (std::size_t i = 0; i < std::size(kNames); ++i) kScratch.put(kNames[i], i < parts.size() ? parts[i] : Input{});
  succeeds([&] {
    const PredictionFolder folder = open_predictions(kScratch.path());
    const Segmentation segmentation = read_prediction(folder, 0);
    require(check(segmentation, folder.width, folder.height).used, "what was read can be used");
  });
}

}  // namespace panoptic::fuzz
