// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The smallest whole program: a recording in, a labelled scene out.
//   01_map_a_recording OPTIONS.toml RECORDING SCENE.glb
// The options name the label set and the networks: `labels = "indoor"`, `[networks]`, `semantic = "....toml"`, `instance =
// "....toml"`.
#include <panoptic/panoptic.h>

#include <cstdio>

int main(int argc, char** argv) try {
  if (argc != 4) return std::fprintf(stderr, "usage: %s OPTIONS.toml RECORDING SCENE.glb\n", argv[0]), 2;
  const auto options = panoptic::load_options(argv[1]);
  const auto dataset = panoptic::open_dataset(argv[2]);
  const auto predictor = panoptic::make_predictor(options);
  panoptic::Session session(options, panoptic::labels_of(options, predictor.get()));
  for (const panoptic::Frame& frame : *dataset) {
    session.add(frame, predictor ? predictor->predict(frame) : panoptic::Segmentation{});
  }
  session.finish();
  panoptic::write_glb(argv[3], session.mesh(), session.map().labels);
  return 0;
} catch (const panoptic::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
