// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects.h"

#include <algorithm>
#include <iterator>
#include <limits>

#include "panoptic/error.h"

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

ObjectRegistry::ObjectRegistry(std::uint16_t first_thing) : first_thing_(first_thing) {
  state_.next_id = PanopticId{first_thing};
}

ObjectRegistry::ObjectRegistry(std::uint16_t first_thing, RegistryState state)
    : first_thing_(first_thing), state_(std::move(state)) {
  for (const Object& object : state_.objects) {
    if (object.id != PanopticId::kUnknown) slot_of_.emplace(object.id, object.slot);
  }
}

std::optional<std::size_t> ObjectRegistry::free_place() {
  std::vector<Object>& objects = state_.objects;
  if (first_thing_ + objects.size() < number(LabelSlot::kNoVote)) {
    objects.emplace_back();
    return objects.size() - 1;
  }
  const auto is_taken = [&](std::size_t place) {
    return objects[place].id != PanopticId::kUnknown || find_left(static_cast<LabelSlot>(first_thing_ + place)) != nullptr;
  };
  while (free_from_ < objects.size() && is_taken(free_from_)) ++free_from_;
  return free_from_ < objects.size() ? std::optional(free_from_) : std::nullopt;
}

std::optional<LabelSlot> ObjectRegistry::create(std::int64_t frame) {
  ++state_.created_since_retirement;
  if (number(state_.next_id) == std::numeric_limits<std::uint32_t>::max()) {
    ++state_.refused;
    return std::nullopt;
  }
  const std::optional<LabelSlot> slot = recreate(state_.next_id, frame);
  if (slot) state_.next_id = static_cast<PanopticId>(number(state_.next_id) + 1);
  return slot;
}

std::optional<LabelSlot> ObjectRegistry::recreate(PanopticId id, std::int64_t frame, PartHistory parts) {
  const std::optional<std::size_t> place = free_place();
  if (!place) {
    ++state_.refused;
    return std::nullopt;
  }
  Object& object = state_.objects[*place];
  object.id = id;
  object.slot = static_cast<LabelSlot>(first_thing_ + *place);
  object.first_frame = frame;
  object.last_frame = frame;
  object.parts = std::move(parts);
  if (object.parts.count() == 0) {  // whoever merged them was forgotten, but not that they were merged
    for (const MergedObject& merged : state_.merged) {
      if (merged.into == id) object.parts.add({merged.id, frame});
    }
  }
  slot_of_.emplace(object.id, object.slot);
  return object.slot;
}

// The object is no more, but something may still name its slot.
void ObjectRegistry::leave(Object& object) {
  const auto at = std::ranges::lower_bound(state_.left, object.slot, {}, &LeftSlot::slot);
  state_.left.insert(at, {object.slot, object.id});
  slot_of_.erase(object.id);
  object = Object{};
}

void ObjectRegistry::retire_unused(const std::vector<bool>& in_voxels, const std::vector<bool>& elsewhere) {
  const auto is_free = [&](LabelSlot slot) {
    return !in_voxels[number(slot)] && (elsewhere.empty() || !elsewhere[number(slot)]);
  };
  std::vector<LeftSlot> left;
  std::ranges::copy_if(state_.left, std::back_inserter(left), [&](const LeftSlot& l) { return !is_free(l.slot); });
  for (Object& object : state_.objects) {
    if (object.id == PanopticId::kUnknown || in_voxels[number(object.slot)]) continue;
    if (!is_free(object.slot)) left.push_back({object.slot, object.id});
    slot_of_.erase(object.id);
    object = Object{};
  }
  std::ranges::sort(left, {}, &LeftSlot::slot);
  state_.left = std::move(left);
  state_.created_since_retirement = 0;
  free_from_ = 0;
}

Object& ObjectRegistry::at(LabelSlot slot) {
  PANOPTIC_ASSERT(find(slot) != nullptr);
  return state_.objects[number(slot) - first_thing_];
}

void ObjectRegistry::observe(LabelSlot slot, const Segment& segment, std::int64_t frame) {
  Object& object = at(slot);
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

void ObjectRegistry::show(LabelSlot slot, const ObjectView& view) { at(slot).best_views.add(view); }

void ObjectRegistry::merge(LabelSlot from, LabelSlot into, std::int64_t frame) {
  PANOPTIC_ASSERT(from != into);
  Object& part = at(from);
  Object& whole = at(into);
  add_observations(part, whole);
  whole.parts.merge(part.parts);
  merge_absent(part.id, into, frame);
  leave(part);
}

void ObjectRegistry::merge_absent(PanopticId from, LabelSlot into, std::int64_t frame) {
  Object& whole = at(into);
  whole.parts.add({from, frame});
  for (MergedObject& merged : state_.merged) {
    if (merged.into == from) merged.into = whole.id;
  }
  const auto place = std::ranges::lower_bound(state_.merged, from, {}, &MergedObject::id);
  state_.merged.insert(place, {from, whole.id});
}

PanopticId ObjectRegistry::survivor(PanopticId id) const {
  const auto merged = std::ranges::lower_bound(state_.merged, id, {}, &MergedObject::id);
  return merged == state_.merged.end() || merged->id != id ? id : merged->into;
}

LabelSlot ObjectRegistry::survivor(LabelSlot slot) const {
  const LeftSlot* left = find_left(slot);
  const Object* survivor = left == nullptr ? nullptr : find(this->survivor(left->id));
  return survivor == nullptr ? slot : survivor->slot;
}

const LeftSlot* ObjectRegistry::find_left(LabelSlot slot) const {
  const auto at = std::ranges::lower_bound(state_.left, slot, {}, &LeftSlot::slot);
  return at == state_.left.end() || at->slot != slot ? nullptr : &*at;
}

const Object* ObjectRegistry::find(LabelSlot slot) const {
  const std::size_t place = std::size_t{number(slot)} - first_thing_;
  const bool known =
      number(slot) >= first_thing_ && place < state_.objects.size() && state_.objects[place].id != PanopticId::kUnknown;
  return known ? &state_.objects[place] : nullptr;
}

const Object* ObjectRegistry::find(PanopticId id) const {
  const auto slot = slot_of_.find(id);
  return slot == slot_of_.end() ? nullptr : find(slot->second);
}

PanopticId ObjectRegistry::named_by(LabelSlot slot) const {
  if (const Object* object = find(slot)) return object->id;
  const LeftSlot* left = find_left(slot);
  return left == nullptr ? PanopticId::kUnknown : left->id;
}

PanopticId ObjectRegistry::id_of(LabelSlot slot) const {
  if (number(slot) < first_thing_) return static_cast<PanopticId>(number(slot));
  if (const Object* object = find(slot)) return object->id;
  const Object* object = find(survivor(slot));
  return object == nullptr ? PanopticId::kUnknown : object->id;
}

void ObjectRegistry::rule_out(LabelSlot slot, std::set<ClassId> classes) { at(slot).ruled_out = std::move(classes); }

void ObjectRegistry::assume(LabelSlot slot, ClassId class_id) {
  PANOPTIC_ASSERT(class_of(slot) == ClassId::kUnknown);
  at(slot).evidence[class_id] = 0;
}

ClassId ObjectRegistry::class_of(LabelSlot slot) const {
  const Object* object = find(slot);
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

std::vector<ClassProbability> ObjectRegistry::probabilities(LabelSlot slot) const {
  std::vector<ClassProbability> result;
  const Object* object = find(slot);
  if (object == nullptr || object->score_sum <= 0) return result;
  for (const auto& [class_id, evidence] : object->evidence) {
    result.push_back({class_id, static_cast<float>(evidence / object->score_sum)});
  }
  return result;
}

}  // namespace panoptic
