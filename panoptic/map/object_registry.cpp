// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map/object_registry.h"

#include <algorithm>

#include "panoptic/base/error.h"

namespace panoptic {

std::optional<PanopticId> ObjectRegistry::create() {
  created_since_retirement_++;
  const std::size_t id = first_thing_ + objects_.size();
  if (id >= number(PanopticId::kNoVote)) return reuse();
  objects_.emplace_back().id = static_cast<PanopticId>(id);
  return objects_.back().id;
}

std::optional<PanopticId> ObjectRegistry::reuse() {
  if (retired_ == 0) return std::nullopt;
  const auto free = std::find_if(objects_.begin(), objects_.end(), [](const Object& o) { return o.id == PanopticId::kUnknown; });
  retired_--;
  free->id = static_cast<PanopticId>(first_thing_ + (free - objects_.begin()));
  return free->id;
}

void ObjectRegistry::retire_unused(const std::vector<bool>& in_use) {
  for (Object& object : objects_) {
    if (object.id == PanopticId::kUnknown || in_use[number(object.id)]) continue;
    object = Object{};
    retired_++;
  }
  created_since_retirement_ = 0;
}

void ObjectRegistry::observe(PanopticId id, const Segment& segment, std::int64_t frame) {
  PANOPTIC_ASSERT(find(id) != nullptr);
  Object& object = objects_[number(id) - first_thing_];
  object.first_frame = object.observations == 0 ? frame : std::min(object.first_frame, frame);
  object.last_frame = object.observations == 0 ? frame : std::max(object.last_frame, frame);
  object.observations++;
  object.score_sum += segment.score;
  object.votes.add(frame, segment.class_id);
  if (segment.class_probabilities.empty()) {
    object.evidence[segment.class_id] += segment.score;
  }
  for (const ClassProbability& p : segment.class_probabilities) {
    object.evidence[p.class_id] += static_cast<double>(segment.score) * p.probability;
  }
}

void ObjectRegistry::show(PanopticId id, const ObjectView& view) {
  PANOPTIC_ASSERT(find(id) != nullptr);
  objects_[number(id) - first_thing_].best_views.add(view);
}

const Object* ObjectRegistry::find(PanopticId id) const {
  const std::size_t i = std::size_t{number(id)} - first_thing_;
  const bool known = number(id) >= first_thing_ && i < objects_.size() && objects_[i].id == id;
  return known ? &objects_[i] : nullptr;
}

ClassId ObjectRegistry::class_of(PanopticId id) const {
  const Object* object = find(id);
  if (object == nullptr || object->evidence.empty()) return ClassId::kUnknown;
  const auto best = std::max_element(object->evidence.begin(), object->evidence.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  return best->first;
}

std::vector<ClassProbability> ObjectRegistry::probabilities(PanopticId id) const {
  std::vector<ClassProbability> result;
  const Object* object = find(id);
  if (object == nullptr || object->score_sum <= 0) return result;
  for (const auto& [class_id, evidence] : object->evidence) {
    result.push_back({class_id, static_cast<float>(evidence / object->score_sum)});
  }
  return result;
}

}  // namespace panoptic
