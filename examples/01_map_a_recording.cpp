// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The smallest whole program: a recording in, a labelled scene out.
//   01_map_a_recording OPTIONS.toml RECORDING SCENE.glb
// The options name the label set and the networks: `labels = "indoor"`, `[networks]`, `semantic = "....toml"`, `instance =
// "....toml"`.
#include <panoptic/map.h>
#include <panoptic/panoptic.h>

#include <cstdio>

int main(int argc, char** argv) try {
  if (argc != 4) return std::fprintf(stderr, "usage: %s OPTIONS.toml RECORDING SCENE.glb\n", argv[0]), 2;
  const auto options = panoptic::load_options(argv[1]);
  const auto dataset = panoptic::open_recording(argv[2]);
  const auto predictor = panoptic::make_predictor(options);
  panoptic::Mapper mapper(options, panoptic::labels_of(options, predictor.get()));
  for (const panoptic::Frame& frame : *dataset) {
    const auto segmentation = predictor ? predictor->predict(frame) : panoptic::Segmentation{};
    const panoptic::Outcome outcome = mapper.add(frame, segmentation);
    if (!outcome.used) std::fprintf(stderr, "frame %lld: %s\n", static_cast<long long>(frame.index), outcome.reason.c_str());
  }
  mapper.finish();
  panoptic::write_glb(argv[3], mapper.mesh(), mapper.map().labels);
  return 0;
} catch (const panoptic::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
