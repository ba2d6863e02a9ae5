// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/eval/submission.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "panoptic/base/files.h"
#include "panoptic/error.h"
#include "panoptic/eval/instance_ap.h"
#include "panoptic/eval/labelled_vertices.h"
#include "panoptic/io/scannet_scan.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMaxTextBytes = std::uintmax_t{512} << 20;
constexpr std::int64_t kPerClass = 1000;
constexpr std::array<std::string_view, 2> kResults = {"semantic_label_evaluation", "semantic_instance_evaluation"};

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const std::size_t begin = text.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlank) - begin + 1);
}

// Calls back with every line and its number, counted from 1. Blank lines at the end are no lines.
template <typename Body>
void for_each_text_line(std::string_view text, const Body& body) {
  while (!text.empty() && std::string_view(" \t\r\n").find(text.back()) != std::string_view::npos) text.remove_suffix(1);
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    body(line, trimmed(text.substr(0, end)));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
}

// Calls back with the number of every line.
template <typename Body>
void for_each_number(const fs::path& path, const Body& body) {
  const std::string text = read_file(path, kMaxTextBytes);
  for_each_text_line(text, [&](std::size_t line, std::string_view word) {
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size()) {
      throw Error(fmt::format("{}:{}: expected a whole number, found '{}'", path.string(), line, word.substr(0, 40)));
    }
    body(value);
  });
}

std::vector<std::int64_t> read_labels(const fs::path& path) {
  std::vector<std::int64_t> numbers;
  for_each_number(path, [&](std::int64_t value) { numbers.push_back(value); });
  return numbers;
}

double to_finite(std::string_view word, const char* what, const std::string& where) {
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) {
    throw Error(fmt::format("{}: the {} '{}' is not a finite number", where, what, word.substr(0, 40)));
  }
  return value;
}

// The mask's file, or an Error if it is not inside the folder.
fs::path mask_path(const fs::path& folder, std::string_view name, const std::string& where) {
  const fs::path relative = fs::path(name).lexically_normal();
  if (relative.is_absolute())
    throw Error(fmt::format("{}: the mask path '{}' is absolute; make it relative to this file", where, name));
  if (relative.empty() || *relative.begin() == "..")
    throw Error(fmt::format("{}: the mask path '{}' leaves the folder", where, name));
  return folder / relative;
}

std::vector<std::uint32_t> read_mask(const fs::path& path, std::size_t vertices) {
  std::vector<std::uint32_t> members;
  std::size_t count = 0;
  for_each_number(path, [&](std::int64_t value) {
    if (value != 0 && count < vertices) members.push_back(static_cast<std::uint32_t>(count));
    ++count;
  });
  if (count != vertices) {
    throw Error(fmt::format("{}: {} lines, but the ground truth has {} vertices; a mask has one number per vertex", path.string(),
                            count, vertices));
  }
  return members;
}

template <typename Range, typename ToNumber>
std::string lines_of(const Range& range, const ToNumber& to_number) {
  std::string text;
  for (const auto& item : range) fmt::format_to(std::back_inserter(text), "{}\n", to_number(item));
  return text;
}

std::string semantic_text(const std::vector<ClassId>& classes) {
  return lines_of(classes, [](ClassId id) { return number(id); });
}

// class * 1000 + instance; things are numbered from 1 within their class, number 0 stays.
std::string panoptic_text(const VertexLabels& labels, const std::string& scene) {
  std::map<std::pair<ClassId, std::uint32_t>, std::int64_t> id_of;
  for (std::size_t v = 0; v < labels.class_id.size(); ++v) id_of[{labels.class_id[v], labels.instance[v]}] = 0;
  std::map<ClassId, std::int64_t> count;
  for (auto& [key, id] : id_of) {
    const auto& [class_id, instance] = key;
    if (class_id == ClassId::kUnknown) continue;
    const std::int64_t numbered = instance == 0 ? 0 : ++count[class_id];
    if (numbered >= kPerClass) {
      throw Error(fmt::format("{}: more than {} instances of class {}; the form class * 1000 + instance ends there", scene,
                              kPerClass - 1, number(class_id)));
    }
    id = number(class_id) * kPerClass + numbered;
  }
  std::string text;
  for (std::size_t v = 0; v < labels.class_id.size(); ++v) {
    fmt::format_to(std::back_inserter(text), "{}\n", id_of.find({labels.class_id[v], labels.instance[v]})->second);
  }
  return text;
}

void write_text(const fs::path& folder, const std::string& name, const std::string& text) {
  require_writable_folder(folder);
  write_file(folder / name, text);
}

void write_instances(const fs::path& folder, const std::string& scene, const LabelledVertices& prediction) {
  std::string list;
  std::size_t k = 0;
  for (const InstanceMask& mask : instance_masks(prediction)) {
    if (mask.vertices.size() < kMinRegionVertices) continue;
    std::vector<std::uint8_t> members(prediction.labels.class_id.size());
    for (const std::uint32_t v : mask.vertices) members[v] = 1;
    const std::string name = fmt::format("{}_{:03}.txt", scene, k++);
    write_text(folder / "pred_mask", name, lines_of(members, [](std::uint8_t member) { return member; }));
    list += fmt::format("pred_mask/{} {} {}\n", name, number(mask.class_id), mask.confidence);
  }
  write_text(folder, scene + ".txt", list);
}

}  // namespace

std::vector<std::string> scenes_in(const fs::path& folder) {
  constexpr std::string_view kSuffix = ".txt";
  if (!is_folder(folder)) throw FileError(fmt::format("cannot read the folder {}: there is none", folder.string()));
  std::vector<std::string> scenes;
  for (std::string name : names_in_folder(folder)) {
    if (!name.ends_with(kSuffix) || name.size() == kSuffix.size() || is_folder(folder / name)) continue;
    name.resize(name.size() - kSuffix.size());
    if (std::find(kResults.begin(), kResults.end(), name) == kResults.end()) scenes.push_back(std::move(name));
  }
  if (scenes.empty()) throw Error(fmt::format("{}: no predictions here; expected one <scene>.txt per scene", folder.string()));
  std::sort(scenes.begin(), scenes.end());
  return scenes;
}

std::vector<ClassId> read_semantic(const fs::path& path, IdSpace space) {
  const std::vector<std::int64_t> numbers = read_labels(path);
  require_classes(path, numbers, space);
  std::vector<ClassId> classes;
  classes.reserve(numbers.size());
  for (const std::int64_t value : numbers) classes.push_back(class_in(value, space));
  return classes;
}

VertexLabels read_panoptic(const fs::path& path, IdSpace space) {
  const std::vector<std::int64_t> numbers = read_labels(path);
  if (space != IdSpace::kTrain) require_class_and_instance(path, numbers);
  std::vector<std::int64_t> classes;
  VertexLabels labels;
  for (const std::int64_t value : numbers) {
    classes.push_back(value < 0 ? -1 : value / kPerClass);
    const ClassId class_id = class_in(classes.back(), space);
    labels.class_id.push_back(class_id);
    labels.instance.push_back(class_id == ClassId::kUnknown ? 0 : static_cast<std::uint32_t>(value % kPerClass));
  }
  require_classes(path, classes, space);
  return labels;
}

std::vector<InstanceMask> read_instances(const fs::path& folder, const std::string& scene, std::size_t vertices, IdSpace space) {
  const fs::path path = folder / (scene + ".txt");
  const std::string text = read_file(path, kMaxTextBytes);
  std::vector<std::pair<fs::path, InstanceMask>> masks;
  std::map<fs::path, std::size_t> place;
  for_each_text_line(text, [&](std::size_t line, std::string_view words) {
    const std::string where = fmt::format("{}:{}", path.string(), line);
    const std::size_t first = words.find(' ');
    const std::size_t second = first == std::string_view::npos ? first : words.find(' ', first + 1);
    if (second == std::string_view::npos || words.find(' ', second + 1) != std::string_view::npos) {
      throw Error(
          fmt::format("{}: expected 'mask_path label_id confidence' with single spaces, found '{}'", where, words.substr(0, 80)));
    }
    InstanceMask mask;
    const double label = to_finite(words.substr(first + 1, second - first - 1), "label", where);
    const bool fits = std::abs(label) <= std::numeric_limits<std::uint16_t>::max();
    mask.class_id = class_in(fits ? static_cast<std::int64_t>(label) : -1, space);
    mask.confidence = to_finite(words.substr(second + 1), "confidence", where);
    const fs::path file = mask_path(folder, words.substr(0, first), where);
    const auto [at, added] = place.emplace(file, masks.size());
    if (added) masks.emplace_back(file, InstanceMask{});
    masks[at->second].second = std::move(mask);
  });
  std::vector<InstanceMask> result;
  for (auto& [file, mask] : masks) {
    mask.vertices = read_mask(file, vertices);
    result.push_back(std::move(mask));
  }
  return result;
}

VertexLabels read_truth(const fs::path& folder, const std::string& scene, SubmissionForm form, const fs::path& category_map) {
  const fs::path file = folder / (scene + ".txt");
  VertexLabels labels;
  if (!is_there(file)) {
    if (!is_folder(folder / scene))
      throw Error(fmt::format("no ground truth for the prediction of {}: neither {} nor a scan in {}", scene, file.string(),
                              (folder / scene).string()));
    labels = labels_of(read_scan_truth(folder / scene, category_map));
  } else if (form == SubmissionForm::kSemantic) {
    labels.class_id = read_semantic(file);
    labels.instance.resize(labels.class_id.size());
  } else {
    labels = read_panoptic(file);
  }
  const bool is_blank =
      std::all_of(labels.class_id.begin(), labels.class_id.end(), [](ClassId id) { return id == ClassId::kUnknown; });
  if (is_blank) throw Error(fmt::format("{}: the ground truth of {} names no class", folder.string(), scene));
  return labels;
}

void write_submission(const fs::path& folder, const std::string& scene, const LabelledVertices& prediction,
                      const VertexLabels& truth) {
  const std::string name = scene + ".txt";
  write_text(folder / "semantic", name, semantic_text(prediction.labels.class_id));
  write_instances(folder / "instance", scene, prediction);
  write_text(folder / "panoptic", name, panoptic_text(prediction.labels, scene));
  const std::string true_ids = panoptic_text(truth, scene);
  write_text(folder / "truth" / "semantic", name, semantic_text(truth.class_id));
  write_text(folder / "truth" / "instance", name, true_ids);
  write_text(folder / "truth" / "panoptic", name, true_ids);
}

}  // namespace panoptic
