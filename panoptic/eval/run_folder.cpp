// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "panoptic/eval/vertex_labels.h"
#include "panoptic/evaluation.h"
#include "panoptic/run_files.h"

namespace panoptic {
namespace {

double confidence_in(const RunObject& object) {
  const auto own = std::ranges::find(object.probabilities, object.class_name, &std::pair<std::string, double>::first);
  const double probability = own == object.probabilities.end() ? 0 : own->second;
  return object_confidence(probability, static_cast<double>(object.observations));
}

}  // namespace

LabelledMap read_run_folder(const std::filesystem::path& folder, std::vector<std::string>* warnings) {
  RunReport report = read_run_report(folder);
  LabelledMap map;
  map.labels = std::move(report.labels);
  map.voxel_size_m = report.voxel_size_m;
  for (const RunObject& object : read_run_objects(folder).objects) map.confidence[object.id] = confidence_in(object);
  map.mesh = read_run_mesh(folder);
  if (warnings == nullptr) return map;
  if (!report.complete) {
    warnings->push_back(fmt::format("{}: the run is marked incomplete; this is the map of its first frames", folder.string()));
  }
  for (std::string& line : foreign_classes(map.labels)) warnings->push_back(std::move(line));
  return map;
}

}  // namespace panoptic
