// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map/object_registry.h"

#include <algorithm>

#include "panoptic/base/error.h"

namespace panoptic {

void add_observations(const Object& from, Object& into) {
  if (from.observations > 0) {
    into.first_frame = into.observations == 0 ? from.first_frame : std::min(into.first_frame, from.first_frame);
    into.last_frame = into.observations == 0 ? from.last_frame : std::max(into.last_frame, from.last_frame);
  }
  into.observations += from.observations;
  into.score_sum += from.score_sum;
  for (const auto& [class_id, evidence] : from.evidence) into.evidence[class_id] += evidence;
  into.votes.merge(from.votes);
  into.best_views.merge(from.best_views);
}

ObjectRegistry::ObjectRegistry(std::uint16_t first_thing, RegistryState state)
    : first_thing_(first_thing), objects_(std::move(state.objects)), created_since_retirement_(state.created_since_retirement) {
  const auto is_gone = [](const Object& o) { return o.id == LabelSlot::kUnknown; };
  retired_ = static_cast<std::size_t>(std::count_if(objects_.begin(), objects_.end(), is_gone));
}

std::optional<LabelSlot> ObjectRegistry::create(std::int64_t frame) {
  created_since_retirement_++;
  const bool all_given = first_thing_ + objects_.size() >= number(LabelSlot::kNoVote);
  Object* object = all_given ? reuse() : &objects_.emplace_back();
  if (object == nullptr) return std::nullopt;
  object->id = static_cast<LabelSlot>(first_thing_ + (object - objects_.data()));
  object->first_frame = frame;
  object->last_frame = frame;
  return object->id;
}

Object* ObjectRegistry::reuse() {
  if (retired_ == 0) return nullptr;
  const auto free = std::find_if(objects_.begin(), objects_.end(), [](const Object& o) {
    return o.id == LabelSlot::kUnknown && o.merged_into == LabelSlot::kUnknown;
  });
  if (free == objects_.end()) return nullptr;
  retired_--;
  return &*free;
}

void ObjectRegistry::retire_unused(const std::vector<bool>& in_use) {
  for (Object& object : objects_) {
    if (object.id == LabelSlot::kUnknown || in_use[number(object.id)]) continue;
    object = Object{};
    retired_++;
  }
  created_since_retirement_ = 0;
}

void ObjectRegistry::observe(LabelSlot id, const Segment& segment, std::int64_t frame) {
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

void ObjectRegistry::show(LabelSlot id, const ObjectView& view) {
  PANOPTIC_ASSERT(find(id) != nullptr);
  objects_[number(id) - first_thing_].best_views.add(view);
}

void ObjectRegistry::merge(LabelSlot from, LabelSlot into, std::int64_t frame) {
  PANOPTIC_ASSERT(from != into && find(from) != nullptr && find(into) != nullptr);
  Object& part = objects_[number(from) - first_thing_];
  Object& whole = objects_[number(into) - first_thing_];
  add_observations(part, whole);
  whole.parts.insert(whole.parts.end(), part.parts.begin(), part.parts.end());
  whole.parts.push_back({from, frame});
  part = Object{};
  part.merged_into = into;
  retired_++;
}

std::vector<std::pair<LabelSlot, LabelSlot>> ObjectRegistry::merged() const {
  std::vector<std::pair<LabelSlot, LabelSlot>> result;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    if (objects_[i].merged_into == LabelSlot::kUnknown) continue;
    const auto id = static_cast<LabelSlot>(first_thing_ + i);
    result.emplace_back(id, survivor(id));
  }
  return result;
}

LabelSlot ObjectRegistry::survivor(LabelSlot id) const {
  while (number(id) >= first_thing_ && std::size_t{number(id)} - first_thing_ < objects_.size()) {
    const LabelSlot next = objects_[number(id) - first_thing_].merged_into;
    if (next == LabelSlot::kUnknown) break;
    id = next;
  }
  return id;
}

const Object* ObjectRegistry::find(LabelSlot id) const {
  const std::size_t i = std::size_t{number(id)} - first_thing_;
  const bool known = number(id) >= first_thing_ && i < objects_.size() && objects_[i].id == id;
  return known ? &objects_[i] : nullptr;
}

void ObjectRegistry::rule_out(LabelSlot id, std::set<ClassId> classes) {
  PANOPTIC_ASSERT(find(id) != nullptr);
  objects_[number(id) - first_thing_].ruled_out = std::move(classes);
}

void ObjectRegistry::assume(LabelSlot id, ClassId class_id) {
  PANOPTIC_ASSERT(class_of(id) == ClassId::kUnknown);
  objects_[number(id) - first_thing_].evidence[class_id] = 0;
}

ClassId ObjectRegistry::class_of(LabelSlot id) const {
  const Object* object = find(id);
  ClassId best = ClassId::kUnknown;
  double most = -1;
  if (object == nullptr) return best;
  for (const auto& [class_id, evidence] : object->evidence) {
    if (evidence <= most || object->ruled_out.contains(class_id)) continue;
    best = class_id;
    most = evidence;
  }
  constexpr double kFaint = 0.03;  // what is left when the likely classes are ruled out may be no more than noise
  if (!object->ruled_out.empty() && most < kFaint * object->score_sum) return ClassId::kUnknown;
  return best;
}

std::vector<ClassProbability> ObjectRegistry::probabilities(LabelSlot id) const {
  std::vector<ClassProbability> result;
  const Object* object = find(id);
  if (object == nullptr || object->score_sum <= 0) return result;
  for (const auto& [class_id, evidence] : object->evidence) {
    result.push_back({class_id, static_cast<float>(evidence / object->score_sum)});
  }
  return result;
}

}  // namespace panoptic
