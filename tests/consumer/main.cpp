// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Maps one made-up frame, a wall of the first stuff class two metres away, and looks at what came out.
#include <panoptic/map.h>
#include <panoptic/panoptic.h>
#include <cstdio>

int main() {
  const panoptic::LabelSet labels = panoptic::load_label_set("indoor");
  const panoptic::ClassId wall = labels.find("wall")->id;
  panoptic::Frame frame;
  frame.depth_camera = frame.color_camera = {160, 120, 140, 140, 79.5, 59.5};
  frame.depth = panoptic::Image<float>(160, 120, 2.0F);
  frame.color = panoptic::Image<panoptic::Rgb>(160, 120, panoptic::Rgb{200, 100, 50});
  const panoptic::Segmentation segmentation{panoptic::Image<std::uint16_t>(160, 120, 1), {panoptic::Segment{wall, 1.0F, {}}}};

  panoptic::Mapper mapper(panoptic::Options{}, labels);
  if (const panoptic::Outcome outcome = mapper.add(frame, segmentation); !outcome.used) {
    std::printf("the frame was refused: %s\n", outcome.reason.c_str());
    return 1;
  }
  const panoptic::Mesh mesh = mapper.mesh();
  std::printf("%zu blocks, %zu vertices\n", mapper.map().voxels.block_count(), mesh.vertices.size());
  return !mesh.vertices.empty() && mesh.vertices[0].class_id == wall ? 0 : 1;
}
