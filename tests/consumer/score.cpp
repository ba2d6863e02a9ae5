// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Maps one made-up frame, a wall two metres away, and scores the map against its own surface, said to be a wall all over.
#include <panoptic/evaluation.h>
#include <panoptic/map.h>
#include <panoptic/panoptic.h>

#include <cstdio>

int main() {
  const panoptic::LabelSet labels = panoptic::load_label_set("indoor");
  panoptic::Frame frame;
  frame.depth_camera = frame.color_camera = {160, 120, 140, 140, 79.5, 59.5};
  frame.depth = panoptic::Image<float>(160, 120, 2.0F);
  frame.color = panoptic::Image<panoptic::Rgb>(160, 120, panoptic::Rgb{200, 100, 50});
  const panoptic::Segment wall{labels.find("wall")->id, 1.0F, {}};
  panoptic::Mapper mapper(panoptic::Options{}, labels);
  if (!mapper.add(frame, {panoptic::Image<std::uint16_t>(160, 120, 1), {wall}}).used) return 1;

  const panoptic::LabelledMap map = panoptic::labelled_map(mapper.map(), mapper.mesh());
  panoptic::ScanTruth truth;
  truth.scene = "wall";
  truth.triangles = map.mesh.triangles;
  for (const panoptic::MeshVertex& vertex : map.mesh.vertices) truth.positions.push_back(vertex.position);
  truth.class_id.assign(truth.positions.size(), panoptic::benchmark_classes().front().id);
  truth.instance.assign(truth.positions.size(), 0);

  panoptic::Evaluation evaluation;
  evaluation.add(map, truth);
  const panoptic::Scores scores = evaluation.scores();
  std::fputs(panoptic::to_table(scores).c_str(), stdout);
  return scores.semantic->miou == 1.0 && scores.surface->at[0].f_score == 1.0 ? 0 : 1;
}
