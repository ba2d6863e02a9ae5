// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// score_surface MESH TRUTH: the surface of any PLY mesh against that of another, by the metrics of panoptic eval. Prints JSON.
#include <fmt/format.h>

#include <exception>

#include "panoptic/base/json.h"
#include "panoptic/eval/surface_metrics.h"
#include "panoptic/io/scan_ply.h"

namespace panoptic {
namespace {

SurfaceScores scores_of(const char* mesh, const char* truth) {
  ScanTruth map;
  ScanTruth scan;
  read_scan_ply(mesh, map);
  read_scan_ply(truth, scan);
  SurfaceMetrics metrics;
  metrics.add({map.positions, map.triangles}, {scan.positions, scan.triangles});
  return metrics.scores();
}

Json to_json(const SurfaceScores& scores) {
  Json at = Json::array();
  for (const ThresholdScores& t : scores.at) {
    at.push_back({{"threshold_m", t.threshold_m},
                  {"precision", t.precision.value_or(0)},
                  {"recall", t.recall.value_or(0)},
                  {"f_score", t.f_score.value_or(0)}});
  }
  return {
      {"accuracy_m", scores.accuracy_m.value_or(0)}, {"completion_m", scores.completion_m.value_or(0)}, {"at", std::move(at)}};
}

}  // namespace
}  // namespace panoptic

int main(int argc, char** argv) {
  if (argc != 3) {
    fmt::print(stderr, "usage: score_surface MESH.ply TRUTH.ply\n");
    return 2;
  }
  try {
    fmt::print("{}\n", panoptic::to_json(panoptic::scores_of(argv[1], argv[2])).dump(2));
  } catch (const std::exception& e) {
    fmt::print(stderr, "score_surface: {}\n", e.what());
    return 1;
  }
  return 0;
}
