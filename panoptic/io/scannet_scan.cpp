// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/scannet_scan.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "panoptic/base/files.h"
#include "panoptic/base/json.h"
#include "panoptic/error.h"
#include "panoptic/io/category_map.h"
#include "panoptic/io/scan_ply.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMeshSuffix = "_vh_clean_2.ply";
constexpr std::string_view kSegmentsSuffix = "_vh_clean_2.0.010000.segs.json";
constexpr std::string_view kAggregationSuffix = ".aggregation.json";
constexpr std::string_view kCategoryFile = "scannetv2-labels.combined.tsv";
constexpr std::uintmax_t kMaxJsonBytes = std::uintmax_t{256} << 20;
constexpr std::size_t kLabelsInWarning = 5;

// A group of the aggregation file.
struct Group {
  std::uint16_t instance = 0;
  std::string label;
  ClassId class_id = ClassId::kUnknown;
};

std::string joined(const fs::path& folder, const std::string& scene, std::string_view suffix) {
  return (folder / (scene + std::string(suffix))).string();
}

// The id of the scan in the folder: of its only mesh, or of the one that bears the folder's name.
std::string scene_in(const fs::path& folder) {
  if (!is_folder(folder)) throw FileError(fmt::format("cannot read the folder {}: there is none", folder.string()));
  std::vector<std::string> scenes;
  for (const std::string& name : names_in_folder(folder)) {
    if (name.size() > kMeshSuffix.size() && name.ends_with(kMeshSuffix)) {
      scenes.push_back(name.substr(0, name.size() - kMeshSuffix.size()));
    }
  }
  if (scenes.empty()) {
    throw Error(fmt::format("{}: no scan here; expected <scene>{}, <scene>{} and <scene>{}", folder.string(), kMeshSuffix,
                            kSegmentsSuffix, kAggregationSuffix));
  }
  std::string own = fs::absolute(folder / "").lexically_normal().parent_path().filename().string();
  if (std::find(scenes.begin(), scenes.end(), own) != scenes.end()) return own;
  if (scenes.size() > 1)
    throw Error(fmt::format("{}: {} scans in one folder; give the folder of one", folder.string(), scenes.size()));
  return scenes.front();
}

const Json& member(const Json& json, const char* key, const std::string& where) {
  const auto at = json.is_object() ? json.find(key) : json.end();
  if (!json.is_object() || at == json.end()) throw Error(fmt::format("{}: no '{}'", where, key));
  return *at;
}

std::int64_t whole(const Json& json, const std::string& where, std::int64_t max) {
  const bool fits = json.is_number_unsigned() ? json.get<std::uint64_t>() <= static_cast<std::uint64_t>(max)
                                              : json.is_number_integer() && json.get<std::int64_t>() >= 0;
  if (!fits) throw Error(fmt::format("{}: expected a whole number from 0 to {}", where, max));
  return json.get<std::int64_t>();
}

const Json& list(const Json& json, const std::string& where) {
  if (!json.is_array()) throw Error(fmt::format("{}: not a list", where));
  return json;
}

std::vector<std::int64_t> read_segments(const fs::path& path, std::size_t vertices) {
  const Json json = read_json_file(path, kMaxJsonBytes);
  const Json& indices = list(member(json, "segIndices", path.string()), path.string() + ": segIndices");
  if (indices.size() != vertices) {
    throw Error(
        fmt::format("{}: segIndices of {} vertices, but the mesh beside it has {}", path.string(), indices.size(), vertices));
  }
  std::vector<std::int64_t> segments;
  segments.reserve(vertices);
  for (const Json& index : indices) {
    segments.push_back(whole(index, path.string() + ": segIndices", std::numeric_limits<std::int64_t>::max()));
  }
  return segments;
}

// Which group has which segment.
class Aggregation {
 public:
  Aggregation(const fs::path& path, const CategoryMap& categories) : path_(path), categories_(categories) {
    const Json json = read_json_file(path, kMaxJsonBytes);
    const Json& groups = list(member(json, "segGroups", path.string()), path.string() + ": segGroups");
    for (std::size_t i = 0; i < groups.size(); ++i) add(groups[i], fmt::format("{}: segGroups[{}]", path.string(), i));
  }

  const Group* of_segment(std::int64_t segment) const {
    const auto at = group_of_.find(segment);
    return at == group_of_.end() ? nullptr : &groups_[at->second];
  }

  const std::vector<Group>& groups() const { return groups_; }

  void warn(std::vector<std::string>& warnings) const {
    if (!unknown_labels_.empty()) {
      std::string text;
      std::size_t named = 0;
      for (const auto& [label, count] : unknown_labels_) {
        if (++named <= kLabelsInWarning) text += fmt::format("{}'{}'", named == 1 ? "" : ", ", label);
      }
      warnings.push_back(fmt::format("{}: {} labels are no known category and count as not annotated: {}{}", path_.string(),
                                     unknown_labels_.size(), text, named > kLabelsInWarning ? " ..." : ""));
    }
    if (claimed_twice_ > 0) {
      warnings.push_back(
          fmt::format("{}: {} segments are claimed by two groups; the later group has them", path_.string(), claimed_twice_));
    }
  }

 private:
  void add(const Json& json, const std::string& where) {
    constexpr std::int64_t kMaxObject = std::numeric_limits<std::uint16_t>::max() - 1;
    Group group;
    group.instance = static_cast<std::uint16_t>(whole(member(json, "objectId", where), where + ".objectId", kMaxObject) + 1);
    const Json& label = member(json, "label", where);
    if (!label.is_string()) throw Error(fmt::format("{}.label: not a text", where));
    group.label = label.get<std::string>();
    group.class_id = categories_.nyu40(group.label);
    if (!categories_.knows(group.label)) ++unknown_labels_[group.label];
    const std::size_t index = groups_.size();
    groups_.push_back(std::move(group));
    for (const Json& segment : list(member(json, "segments", where), where + ".segments")) {
      const std::int64_t id = whole(segment, where + ".segments", std::numeric_limits<std::int64_t>::max());
      const auto [at, added] = group_of_.emplace(id, index);
      if (!added && at->second != index) {
        at->second = index;
        ++claimed_twice_;
      }
    }
  }

  fs::path path_;
  const CategoryMap& categories_;
  std::vector<Group> groups_;
  std::unordered_map<std::int64_t, std::size_t> group_of_;
  std::map<std::string, std::size_t> unknown_labels_;
  std::size_t claimed_twice_ = 0;
};

CategoryMap categories_for(const fs::path& folder, const fs::path& category_map) {
  if (!category_map.empty()) return CategoryMap(category_map);
  fs::path place = fs::absolute(folder / "").lexically_normal().parent_path();
  for (int level = 0; level < 3; ++level, place = place.parent_path()) {
    if (is_file(place / kCategoryFile)) return CategoryMap(place / kCategoryFile);
  }
  return {};
}

void check_sizes(const ScanTruth& truth) {
  const std::size_t vertices = truth.positions.size();
  if (truth.class_id.size() != vertices || truth.instance.size() != vertices || truth.colors.size() != vertices) {
    throw Error(fmt::format("scan '{}': {} positions, {} colours, {} classes and {} instances; expected as many of each",
                            truth.scene, vertices, truth.colors.size(), truth.class_id.size(), truth.instance.size()));
  }
  if (truth.scene.empty() || truth.scene.find('/') != std::string::npos) {
    throw Error(fmt::format("'{}' is no name for a scan's files; use one such as scene0000_00", truth.scene));
  }
}

// The class of every instance; stuff surfaces without an instance are numbered on. Vertices get their group's instance.
std::map<std::uint16_t, ClassId> number_groups(const ScanTruth& truth, std::vector<std::uint16_t>& group_of) {
  std::map<std::uint16_t, ClassId> classes;
  std::map<ClassId, std::uint16_t> without_instance;
  for (std::size_t i = 0; i < truth.class_id.size(); ++i) {
    const ClassId class_id = truth.class_id[i];
    if (number(class_id) > kNyu40Classes) {
      throw Error(
          fmt::format("scan '{}': vertex {} is of class {}; NYU40 has {}", truth.scene, i, number(class_id), kNyu40Classes));
    }
    if (class_id == ClassId::kUnknown) continue;
    if (truth.instance[i] == 0) {
      without_instance[class_id] = 0;
    } else if (const ClassId first = classes.emplace(truth.instance[i], class_id).first->second; first != class_id) {
      throw Error(fmt::format("scan '{}': instance {} is {} and {}; an instance is of one class", truth.scene, truth.instance[i],
                              nyu40_name(first), nyu40_name(class_id)));
    }
  }
  std::size_t next = classes.empty() ? 1 : classes.rbegin()->first + 1U;
  for (auto& [class_id, instance] : without_instance) {
    if (next > std::numeric_limits<std::uint16_t>::max()) throw Error(fmt::format("scan '{}': too many instances", truth.scene));
    instance = static_cast<std::uint16_t>(next++);
    classes[instance] = class_id;
  }
  group_of.assign(truth.class_id.size(), 0);
  for (std::size_t i = 0; i < group_of.size(); ++i) {
    if (truth.class_id[i] == ClassId::kUnknown) continue;
    group_of[i] = truth.instance[i] != 0 ? truth.instance[i] : without_instance.at(truth.class_id[i]);
  }
  return classes;
}

std::string label_of(std::uint16_t instance, ClassId class_id, const ScanTruth& truth) {
  const auto at = truth.names.find(instance);
  const bool says_it = at != truth.names.end() && nyu40_class(at->second) == class_id;
  const std::string name = says_it ? at->second : std::string(nyu40_name(class_id));
  return name == "otherfurniture" ? "furniture" : name;  // no raw category of ScanNet is called otherfurniture
}

void write_json(const std::string& path, const Json& json) {
  write_file(path, json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");  // one line: a number per vertex
}

}  // namespace

void write_scan_truth(const fs::path& folder, const ScanTruth& truth) {
  check_sizes(truth);
  require_writable_folder(folder);
  std::vector<std::uint16_t> segment_of;
  const std::map<std::uint16_t, ClassId> classes = number_groups(truth, segment_of);
  Json groups = Json::array();
  for (const auto& [instance, class_id] : classes) {
    groups.push_back({{"id", groups.size()},
                      {"objectId", instance - 1},
                      {"segments", Json::array({instance})},
                      {"label", label_of(instance, class_id, truth)}});
  }
  write_scan_ply(joined(folder, truth.scene, kMeshSuffix), truth);
  write_json(joined(folder, truth.scene, kSegmentsSuffix),
             {{"params", Json::object()}, {"sceneId", truth.scene}, {"segIndices", segment_of}});
  write_json(joined(folder, truth.scene, kAggregationSuffix), {{"sceneId", truth.scene},
                                                               {"appId", "PanopticFusion"},
                                                               {"segGroups", std::move(groups)},
                                                               {"segmentsFile", truth.scene + std::string(kSegmentsSuffix)}});
}

ScanTruth read_scan_truth(const fs::path& folder, const fs::path& category_map, std::vector<std::string>* warnings) {
  ScanTruth truth;
  truth.scene = scene_in(folder);
  const CategoryMap categories = categories_for(folder, category_map);
  const Aggregation aggregation(joined(folder, truth.scene, kAggregationSuffix), categories);
  read_scan_ply(joined(folder, truth.scene, kMeshSuffix), truth);
  const std::vector<std::int64_t> segments = read_segments(joined(folder, truth.scene, kSegmentsSuffix), truth.positions.size());
  truth.class_id.resize(segments.size());
  truth.instance.resize(segments.size());
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const Group* group = aggregation.of_segment(segments[i]);
    if (group == nullptr) continue;
    truth.class_id[i] = group->class_id;
    truth.instance[i] = group->instance;
  }
  for (const Group& group : aggregation.groups()) truth.names[group.instance] = group.label;
  if (warnings != nullptr) aggregation.warn(*warnings);
  return truth;
}

}  // namespace panoptic
