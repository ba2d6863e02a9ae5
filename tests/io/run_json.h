// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// report.json and an entry of objects.json as a run writes them, for tests that read them.
#pragma once

#include <string>

#include "panoptic/base/json.h"

namespace panoptic::test {

inline Json report_json() {
  return Json::parse(R"({"dataset": "made for a test", "recording": "sim:7", "calibration": null, "predictor": "networks",
      "complete": true, "frames": {"used": 40, "skipped": 2, "without_prediction": 4}, "wall_s": 2.5, "peak_rss_mb": 80,
      "stages": {"fusion": {"count": 40, "mean_ms": 3, "p50_ms": 2.5, "p95_ms": 5, "max_ms": 9}},
      "up": [0, 2, 0], "label_set": "small",
      "labels": [{"id": 1, "name": "floor", "is_thing": false, "color": [200, 180, 160]},
                 {"id": 2, "name": "swivel chair", "is_thing": true, "color": [31, 119, 180]}],
      "options": {"map": {"voxel_size_m": 0.024}}})");
}

inline Json object_json(int id, const std::string& class_name) {
  return {
      {"id", id},
      {"class_id", 2},
      {"class", class_name},
      {"probabilities", {{"floor", 0.25}, {class_name, 0.75}}},
      {"box", {{"min_m", {-1, 0, 0}}, {"max_m", {1, 2, 3}}}},
      {"oriented_box", {{"size_m", {3, 2, 1}}}},
      {"surface_area_m2", 4.5},
      {"vertices", 100},
      {"first_frame", 3},
      {"last_frame", 40},
      {"observations", 5},
      {"votes", {{"frames_per_bin", 4}, {"bins", {{{"first_frame", 0}, {"classes", {{"floor", 1}, {class_name, 4}}}}}}}},
      {"best_views", {{{"frame", 7}, {"class", class_name}, {"score", 0.5}, {"visible_px", 900}, {"box_px", {10, 20, 50, 60}}}}},
      {"history", {"after frame 20: joined with object 33, a part of it"}}};
}

}  // namespace panoptic::test
