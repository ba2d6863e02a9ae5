// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/evaluation.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <utility>

#include "panoptic/base/json.h"
#include "panoptic/error.h"
#include "panoptic/eval/vertex_labels.h"
#include "panoptic/outputs.h"

namespace panoptic {
namespace {

const Json& member(const Json& json, const char* key, const std::string& where) {
  const auto at = json.is_object() ? json.find(key) : json.end();
  if (!json.is_object() || at == json.end())
    throw Error(fmt::format("{}: no '{}'; is this a folder that panoptic run wrote?", where, key));
  return *at;
}

const Json& list(const Json& json, const char* key, const std::string& where) {
  const Json& value = member(json, key, where);
  if (!value.is_array()) throw Error(fmt::format("{}: '{}' is not a list", where, key));
  return value;
}

std::string text(const Json& json, const char* key, const std::string& where) {
  const Json& value = member(json, key, where);
  if (!value.is_string()) throw Error(fmt::format("{}: '{}' is not a text", where, key));
  return value.get<std::string>();
}

double number(const Json& json, const char* key, const std::string& where) {
  const Json& value = member(json, key, where);
  if (!value.is_number()) throw Error(fmt::format("{}: '{}' is not a number", where, key));
  return value.get<double>();
}

template <typename Id>
Id id(const Json& json, const char* key, const std::string& where) {
  const double value = number(json, key, where);
  const bool fits = value >= 0 && value <= std::numeric_limits<Id>::max() && value == std::floor(value);
  if (!fits) {
    throw Error(
        fmt::format("{}: '{}' is {}; expected a whole number from 0 to {}", where, key, value, std::numeric_limits<Id>::max()));
  }
  return static_cast<Id>(value);
}

LabelSet read_labels(const Json& report, const std::string& where) {
  std::vector<LabelClass> classes;
  for (const Json& entry : list(report, "labels", where)) {
    const Json& is_thing = member(entry, "is_thing", where);
    if (!is_thing.is_boolean()) throw Error(fmt::format("{}: 'is_thing' is neither true nor false", where));
    classes.push_back({ClassId{id<std::uint16_t>(entry, "id", where)}, text(entry, "name", where), is_thing.get<bool>(), {}});
  }
  try {
    return {text(report, "label_set", where), std::move(classes)};
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}", where, e.what()));
  }
}

double read_voxel_size_m(const Json& report, const std::string& where) {
  const double size_m = number(member(member(report, "options", where), "map", where), "voxel_size_m", where);
  if (!(size_m > 0) || !std::isfinite(size_m))
    throw Error(fmt::format("{}: voxel_size_m is {}; expected a length", where, size_m));
  return size_m;
}

// object_confidence of every object in an objects.json.
std::map<PanopticId, double> object_confidences(const Json& objects, const std::string& source) {
  std::map<PanopticId, double> confidences;
  for (const Json& object : list(objects, "objects", source)) {
    const Json& probabilities = member(object, "probabilities", source);
    const std::string class_name = text(object, "class", source);
    const bool has_class = probabilities.is_object() && probabilities.contains(class_name);
    const double probability = has_class ? number(probabilities, class_name.c_str(), source) : 0;
    const double observations = number(object, "observations", source);
    if (!(probability >= 0 && probability <= 1) || !(observations >= 0)) {
      throw Error(fmt::format("{}: an object with probability {} and {} observations", source, probability, observations));
    }
    confidences[PanopticId{id<std::uint32_t>(object, "id", source)}] = object_confidence(probability, observations);
  }
  return confidences;
}

}  // namespace

LabelledMap read_run_folder(const std::filesystem::path& folder, std::vector<std::string>* warnings) {
  const std::string report_path = (folder / "report.json").string();
  const std::string objects_path = (folder / "objects.json").string();
  const Json report = read_json_file(report_path);
  LabelledMap map;
  map.labels = read_labels(report, report_path);
  map.voxel_size_m = read_voxel_size_m(report, report_path);
  map.confidence = object_confidences(read_json_file(objects_path), objects_path);
  map.mesh = read_ply(folder / "mesh.ply");
  if (warnings != nullptr) {
    if (report.value("complete", Json(true)) != Json(true)) {
      warnings->push_back(fmt::format("{}: the run is marked incomplete; this is the map of its first frames", report_path));
    }
    for (std::string& line : foreign_classes(map.labels)) warnings->push_back(std::move(line));
  }
  return map;
}

}  // namespace panoptic
