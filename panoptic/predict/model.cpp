// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predict/model.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>
#include <sstream>

#include "panoptic/base/config.h"
#include "panoptic/base/files.h"
#include "panoptic/base/os.h"
#include "panoptic/error.h"
#include "panoptic/predict/class_names.h"

namespace panoptic {
namespace {

constexpr int kMaxInputSide_px = 4096;
constexpr std::size_t kMaxClasses = 4096;

Fields fields(InputFormat& input) {
  const Allowed side{.min = 1, .max = kMaxInputSide_px, .choices = {}, .required = true};
  return {{"width", &input.width, "pixels of the network's input", side},
          {"height", &input.height, "pixels of the network's input", side},
          {"channels", &input.channels, "order of the channels", one_of({"rgb", "bgr"})},
          {"resize", &input.resize, "stretch fills the input; letterbox keeps the aspect", one_of({"stretch", "letterbox"})},
          {"pad_value", &input.pad_value, "grey around a letterboxed image", in_range(0, 255)},
          {"scale", &input.scale, "(pixel * scale - mean) / std", in_range(1e-6, 1e3)},
          {"mean", &input.mean, "per channel", in_range(-1e6, 1e6)},
          {"std", &input.std, "per channel", in_range(1e-6, 1e6)}};
}

Fields fields(Thresholds& thresholds) {
  return {{"score", &thresholds.score, "instances below are dropped", in_range(0, 1)},
          {"nms_iou", &thresholds.nms_iou, "of two boxes of one class that overlap more, the better one stays", in_range(0, 1)},
          {"mask", &thresholds.mask, "a pixel belongs to the object above", in_range(0, 1)},
          {"min_area_px", &thresholds.min_area_px, "smaller masks are dropped", in_range(1, 1e9)},
          {"max_instances", &thresholds.max_instances, "per frame, the best ones", in_range(1, 10000)}};
}

Fields fields(Model& model, std::string& classes_file) {
  Fields result = {
      {"name", &model.name, "the network's name", required()},
      {"task", &model.task, "what it predicts; left out: what it is used for", one_of({"", "semantic", "instance", "panoptic"})},
      {"decoder", &model.decoder, "how its outputs are read; left out: as they look", {}},
      {"outputs", &model.outputs, "what the outputs do not say themselves: role = name of the output", {}},
      {"weights", &model.weights, "the ONNX file", required()},
      {"weights_opencv", &model.weights_opencv, "the ONNX file for OpenCV, where it needs another one", {}},
      {"weights_folders", &model.weights_folders, "where the weights may lie, relative to this file", {}},
      {"classes", &model.classes, "the network's classes in order", {}},
      {"classes_file", &classes_file, "a file with one class a line, instead of classes", {}},
      {"class_map", &model.class_maps, "[class_map.<label set>]: network class = class of the label set", {}}};
  append_group(result, "input", fields(model.input));
  append_group(result, "thresholds", fields(model.thresholds));
  return result;
}

std::vector<std::string> read_lines(const std::filesystem::path& path) {
  constexpr std::uintmax_t kMaxBytes = 1 << 20;
  std::istringstream text(read_file(path, kMaxBytes));
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) {
    line.erase(line.find_last_not_of(" \t\r") + 1);
    if (!line.empty()) lines.push_back(line);
  }
  return lines;
}

void check_outputs(const Model& model) {
  constexpr std::array<std::string_view, 11> kRoles = {"semantic", "boxes",  "labels", "scores", "masks",      "distribution",
                                                       "classes",  "layout", "values", "order",  "first_class"};
  for (const auto& [role, output] : model.outputs) {
    if (std::find(kRoles.begin(), kRoles.end(), role) != kRoles.end()) continue;
    throw Error(fmt::format("{}: [outputs] has no entry '{}': use {}", model.path.string(), role, fmt::join(kRoles, ", ")));
  }
}

void check(const Model& model) {
  const std::string file = model.path.string();
  check_outputs(model);
  const std::set<std::string> unique(model.classes.begin(), model.classes.end());
  if (model.classes.empty()) throw Error(fmt::format("{}: give the network's classes: classes = [...] or classes_file", file));
  if (model.classes.size() > kMaxClasses) throw Error(fmt::format("{}: more than {} classes", file, kMaxClasses));
  if (unique.size() != model.classes.size()) throw Error(fmt::format("{}: two classes have one name; make them differ", file));
  if (model.input.mean.size() != 3 || model.input.std.size() != 3) {
    throw Error(fmt::format("{}: input.mean and input.std must have three numbers", file));
  }
}

std::filesystem::path lexical_join(const std::filesystem::path& folder, const std::string& file) {
  return (folder / file).lexically_normal();
}

// ":12", the line of the entry of a class map, for the error text; nothing if the file is written in another style.
std::string line_of(const Model& model, const std::string& label_set, const std::string& key) {
  const std::vector<std::string> sections = {fmt::format("[class_map.{}]", label_set),
                                             fmt::format("[class_map.\"{}\"]", label_set)};
  std::istringstream text(read_file(model.path));
  bool inside = false;
  int number = 0;
  for (std::string line; std::getline(text, line);) {
    ++number;
    if (line.starts_with('['))
      inside = std::any_of(sections.begin(), sections.end(), [&](const auto& s) { return line.starts_with(s); });
    if (inside && (line.starts_with(key) || line.starts_with('"' + key + '"'))) return fmt::format(":{}", number);
  }
  return "";
}

std::string names_of(const LabelSet& labels) {
  std::vector<std::string> names;
  for (const LabelClass& c : labels.classes()) names.push_back(c.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

std::vector<ClassId> map_by_name(const Model& model, const LabelSet& labels) {
  std::vector<ClassId> ids(model.classes.size(), ClassId::kUnknown);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const LabelClass* same = counterpart_of(model.classes[i], labels);
    if (same != nullptr) ids[i] = same->id;
  }
  return ids;
}

std::vector<ClassId> map_by_table(const Model& model, const LabelSet& labels, const std::map<std::string, std::string>& table) {
  std::vector<ClassId> ids(model.classes.size(), ClassId::kUnknown);
  for (const auto& [from, to] : table) {
    const auto found = std::find(model.classes.begin(), model.classes.end(), from);
    if (found == model.classes.end()) {
      throw Error(fmt::format("{}{}: class_map.{}: '{}' is not a class of the network; its classes: {}", model.path.string(),
                              line_of(model, labels.name(), from), labels.name(), from, fmt::join(model.classes, ", ")));
    }
    const LabelClass* target = labels.find(to);
    if (target == nullptr) {
      throw Error(fmt::format("{}{}: class_map.{}: '{}' is not in the label set '{}'; its classes: {}", model.path.string(),
                              line_of(model, labels.name(), from), labels.name(), to, labels.name(), names_of(labels)));
    }
    ids[static_cast<std::size_t>(found - model.classes.begin())] = target->id;
  }
  return ids;
}

}  // namespace

Model load_model(const std::filesystem::path& path) {
  Model model;
  model.path = path;
  std::string classes_file;
  read_toml_file(path, fields(model, classes_file));
  if (!classes_file.empty()) {
    if (!model.classes.empty()) throw Error(fmt::format("{}: give classes or classes_file, not both", path.string()));
    model.classes = read_lines(lexical_join(path.parent_path(), classes_file));
  }
  check(model);
  return model;
}

std::filesystem::path find_weights(const Model& model, Engine engine) {
  const std::string& file = engine == Engine::kOpenCv && !model.weights_opencv.empty() ? model.weights_opencv : model.weights;
  const std::filesystem::path beside = model.path.parent_path();
  const std::string models = os::environment("PANOPTIC_MODELS");
  std::vector<std::filesystem::path> tried = {lexical_join(beside, file)};
  if (!models.empty()) tried.push_back(lexical_join(models, file));
  for (const std::string& folder : model.weights_folders) tried.push_back(lexical_join(beside / folder, file));
  for (const std::filesystem::path& candidate : tried) {
    std::error_code error;
    if (std::filesystem::is_regular_file(candidate, error)) return candidate;
  }
  std::vector<std::string> places;
  for (const std::filesystem::path& candidate : tried) places.push_back(candidate.string());
  throw Error(fmt::format("{}: the weights '{}' are in none of: {}; put them there or set $PANOPTIC_MODELS to their folder",
                          model.path.string(), file, fmt::join(places, ", ")));
}

std::vector<ClassId> map_classes(const Model& model, const LabelSet& labels) {
  const auto table = model.class_maps.find(labels.name());
  const bool by_table = table != model.class_maps.end();
  std::vector<ClassId> ids = by_table ? map_by_table(model, labels, table->second) : map_by_name(model, labels);
  if (std::all_of(ids.begin(), ids.end(), [](ClassId id) { return id == ClassId::kUnknown; })) {
    throw Error(
        fmt::format("{}: no class of the network is in the label set '{}'; add [class_map.{}] with lines such as \"{}\" = \"{}\"",
                    model.path.string(), labels.name(), labels.name(), model.classes.front(),
                    labels.classes().empty() ? "wall" : labels.classes().front().name));
  }
  return ids;
}

}  // namespace panoptic
