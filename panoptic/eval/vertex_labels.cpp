// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/eval/vertex_labels.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

#include "panoptic/base/nearest_points.h"
#include "panoptic/io/category_map.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr std::size_t kChunk = 4096;
constexpr ClassId kOtherProp{40};

// Everyday names of classes that NYU40 calls something else. Appliances and plants are furniture-like; the small things that
// lie about are otherprop, which the benchmark does not count.
struct Synonyms {
  std::string_view nyu40;
  std::string_view names;  // each between two bars
};

constexpr std::array<Synonyms, 18> kSynonyms = {{
    {"sofa", "|couch|"},
    {"chair", "|armchair|office chair|"},
    {"table", "|dining table|coffee table|end table|"},
    {"cabinet", "|cupboard|kitchen cabinet|"},
    {"bookshelf", "|bookcase|"},
    {"shelves", "|shelf|"},
    {"counter", "|countertop|kitchen counter|"},
    {"picture", "|painting|poster|"},
    {"curtain", "|drapes|"},
    {"blinds", "|blind|"},
    {"refrigerator", "|fridge|"},
    {"bathtub", "|bath|"},
    {"floor mat", "|rug|carpet|"},
    {"books", "|book|"},
    {"lamp", "|light|"},
    {"bag", "|backpack|handbag|suitcase|"},
    {"otherfurniture", "|other furniture|wardrobe|bench|tv|microwave|oven|toaster|plant|potted plant|"},
    {"otherprop",
     "|laptop|keyboard|mouse|remote|cell phone|clock|vase|bottle|cup|wine glass|bowl|fork|knife|spoon|scissors|teddy bear|hair "
     "drier|toothbrush|umbrella|banana|apple|orange|cat|dog|other|"},
}};

// The NYU40 class of every class number a map can hold.
std::vector<ClassId> class_table(const LabelSet& labels) {
  std::vector<ClassId> table(std::size_t{std::numeric_limits<std::uint16_t>::max()} + 1, ClassId::kUnknown);
  for (const LabelClass& c : labels.classes()) table[number(c.id)] = nyu40_of_class_name(c.name).value_or(kOtherProp);
  return table;
}

double probability_of_class(const ObjectRegistry& objects, LabelSlot slot) {
  const std::vector<ClassProbability> all = objects.probabilities(slot);
  const auto own = std::ranges::find(all, objects.class_of(slot), &ClassProbability::class_id);
  return own == all.end() ? 0 : static_cast<double>(own->probability);
}

}  // namespace

std::optional<ClassId> nyu40_of_class_name(std::string_view name) {
  const ClassId own = nyu40_class(name);
  if (own != ClassId::kUnknown) return own;
  if (name.find('|') != std::string_view::npos) return std::nullopt;
  const std::string barred = fmt::format("|{}|", name);
  const auto* at = std::find_if(kSynonyms.begin(), kSynonyms.end(),
                                [&](const Synonyms& s) { return s.names.find(barred) != std::string_view::npos; });
  if (at == kSynonyms.end()) return std::nullopt;
  return nyu40_class(at->nyu40);
}

std::vector<std::string> foreign_classes(const LabelSet& labels) {
  std::vector<std::string> lines;
  for (const LabelClass& c : labels.classes()) {
    if (!nyu40_of_class_name(c.name)) {
      lines.push_back(
          fmt::format("class '{}' of the label set '{}' is none of NYU40's and counts as otherprop", c.name, labels.name()));
    }
  }
  return lines;
}

double object_confidence(double class_probability, double observations) {
  constexpr double kHalfTrusted = 10;  // after so many frames
  return class_probability * observations / (observations + kHalfTrusted);
}

LabelledMap labelled_map(const PanopticMap& map, Mesh mesh, std::vector<std::string>* warnings) {
  if (warnings != nullptr) {
    for (std::string& line : foreign_classes(map.labels)) warnings->push_back(std::move(line));
  }
  LabelledMap result{std::move(mesh), map.labels, {}, static_cast<double>(map.voxels.voxel_size_m())};
  for (const MeshVertex& vertex : result.mesh.vertices) {
    const Object* object = map.objects.find(vertex.panoptic_id);
    if (object == nullptr || result.confidence.contains(object->id)) continue;
    result.confidence[object->id] =
        object_confidence(probability_of_class(map.objects, object->slot), static_cast<double>(object->observations));
  }
  return result;
}

LabelledVertices carry_labels(const LabelledMap& map, const std::vector<Vec3f>& points) {
  LabelledVertices result;
  result.labels.class_id.resize(points.size());
  result.labels.instance.resize(points.size());
  result.reached.resize(points.size());
  for (const auto& [id, confidence] : map.confidence) result.confidence[number(id)] = confidence;
  std::vector<Vec3f> positions;
  positions.reserve(map.mesh.vertices.size());
  for (const MeshVertex& vertex : map.mesh.vertices) positions.push_back(vertex.position);
  const NearestPoints nearest(std::move(positions));
  const std::vector<ClassId> classes = class_table(map.labels);
  const double reach_m = kReach_voxels * map.voxel_size_m;
  parallel_for((points.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
    const std::size_t end = std::min(points.size(), (chunk + 1) * kChunk);
    for (std::size_t i = chunk * kChunk; i < end; ++i) {
      const auto found = nearest.nearest(points[i]);
      if (!found || found->distance_m > reach_m) continue;
      const MeshVertex& vertex = map.mesh.vertices[found->index];
      result.reached[i] = 1;
      result.labels.class_id[i] = classes[number(vertex.class_id)];
      const bool is_object = result.labels.class_id[i] != ClassId::kUnknown && map.labels.is_object(vertex.panoptic_id);
      result.labels.instance[i] = is_object ? number(vertex.panoptic_id) : 0;
    }
  });
  return result;
}

}  // namespace panoptic
