// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/query.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <tuple>

#include "panoptic/error.h"
#include "panoptic/map/label_extents.h"
#include "panoptic/map/voxel_grid.h"

namespace panoptic {
namespace {

// The square of the distance from a point to the nearest surface voxel of every label.
std::map<LabelSlot, double> squared_distances(const VoxelMap& map, const Vec3d& point_m) {
  const double size = map.voxel_size_m();
  std::map<LabelSlot, double> nearest;
  for (Slot slot = 0; slot < map.block_count(); ++slot) {
    visit_surface(map.block(slot), map.index_of(slot), map.voxel_size_m(), [&](LabelSlot label, const VoxelIndex& voxel) {
      const double squared = (center_m(voxel, size) - point_m).squaredNorm();
      const auto [at, is_new] = nearest.emplace(label, squared);
      if (!is_new) at->second = std::min(at->second, squared);
    });
  }
  return nearest;
}

}  // namespace

MapQuery::MapQuery(const PanopticMap& map) : map_(map) {
  for (const auto& [slot, extent] : label_extents(map.voxels)) {
    const Object* object = map_.objects.find(slot);
    if (object == nullptr) continue;
    FoundObject found{.id = object->id,
                      .slot = slot,
                      .class_id = map_.objects.class_of(slot),
                      .box = box_of(extent, map.voxels.voxel_size_m()),
                      .voxels = extent.voxels};
    for (const ClassProbability& p : map_.objects.probabilities(slot)) {
      if (p.class_id == found.class_id) found.probability = p.probability;
    }
    found.observations = object->observations;
    found.first_frame = object->first_frame;
    found.last_frame = object->last_frame;
    objects_.push_back(found);
  }
  std::ranges::sort(objects_, {}, &FoundObject::id);
}

std::vector<FoundObject> MapQuery::of_class(std::string_view name) const {
  const LabelClass* wanted = map_.labels.find(name);
  const bool unknown = name == map_.labels.name_of(ClassId::kUnknown);
  if (wanted == nullptr && !unknown) {
    std::string known;
    for (const LabelClass& c : map_.labels.classes()) known += (known.empty() ? "" : ", ") + c.name;
    throw Error(fmt::format("there is no class '{}' in this map; its classes are {}", name, known));
  }
  const ClassId id = wanted == nullptr ? ClassId::kUnknown : wanted->id;
  std::vector<FoundObject> found;
  std::copy_if(objects_.begin(), objects_.end(), std::back_inserter(found),
               [&](const FoundObject& o) { return o.class_id == id; });
  return found;
}

std::vector<FoundObject> MapQuery::in_box(const Vec3d& min_m, const Vec3d& max_m) const {
  std::vector<FoundObject> found;
  std::copy_if(objects_.begin(), objects_.end(), std::back_inserter(found), [&](const FoundObject& o) {
    return (o.box.min_m.array() <= max_m.array()).all() && (o.box.max_m.array() >= min_m.array()).all();
  });
  return found;
}

std::vector<NearObject> MapQuery::nearest(const Vec3d& point_m, std::size_t count) const {
  std::vector<NearObject> near;
  if (!point_m.allFinite()) return near;
  const std::map<LabelSlot, double> squared = squared_distances(map_.voxels, point_m);
  for (const FoundObject& object : objects_) near.push_back({object, std::sqrt(squared.at(object.slot))});
  std::sort(near.begin(), near.end(), [](const NearObject& a, const NearObject& b) {
    return std::tuple(a.distance_m, a.object.id) < std::tuple(b.distance_m, b.object.id);
  });
  if (near.size() > count) near.resize(count);
  return near;
}

std::optional<PointAnswer> MapQuery::at(const Vec3d& point_m) const {
  const std::optional<VoxelPlace> place = place_of(point_m, map_.voxels.voxel_size_m());
  if (!place) return std::nullopt;
  const VoxelBlock* block = map_.voxels.find(place->block);
  const Voxel voxel = block == nullptr ? Voxel() : block->at(place->offset);
  if (!(voxel.weight > 0)) return std::nullopt;
  const auto slot = static_cast<LabelSlot>(voxel.label);
  const float share = label_share(voxel.label_weight, voxel.vote_sum);
  return PointAnswer{map_.objects.id_of(slot), map_.class_of(slot), voxel.distance, voxel.weight,
                     slot == LabelSlot::kUnknown ? 0.0F : share};
}

}  // namespace panoptic
