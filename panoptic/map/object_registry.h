// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The things of the map: which class each probably is (Eq. 12), and when it was seen. Evidence is kept per object, never per
// voxel. Networks also find things that never get hold of a voxel; those are retired from time to time, so that the registry
// does not grow with the number of frames. Not thread-safe: one writer, no readers meanwhile.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "panoptic/data/labels.h"
#include "panoptic/data/segmentation.h"
#include "panoptic/map/object_evidence.h"

namespace panoptic {

// Another object that turned out to be a part of this one, and the frame after which that was found.
struct ObjectPart {
  LabelSlot id = LabelSlot::kUnknown;
  std::int64_t frame = 0;

  bool operator==(const ObjectPart&) const = default;
};

struct Object {
  LabelSlot id = LabelSlot::kUnknown;
  std::int64_t first_frame = 0;  // in which it was seen; without observations, after which it was made
  std::int64_t last_frame = 0;
  std::uint64_t observations = 0;
  double score_sum = 0;                // denominator of Eq. 12
  std::map<ClassId, double> evidence;  // its numerator per class: sum of score * p(class)
  std::set<ClassId> ruled_out;         // classes that it cannot be, whatever the evidence
  VoteHistory votes;                   // the class of each observation
  BestViews best_views;
  std::vector<ObjectPart> parts;                // in the order in which they were found
  LabelSlot merged_into = LabelSlot::kUnknown;  // of an object that is no more: the one that it turned out to be a part of

  bool operator==(const Object&) const = default;
};

// Adds what was observed of one object to another, as if both had been one all along. Ids, parts and what is ruled out stay.
void add_observations(const Object& from, Object& into);

// Everything that a registry knows, to save it and to go on from there.
struct RegistryState {
  std::vector<Object> objects;  // by id - first_thing; of a retired or merged one the id is kUnknown, and it has no evidence
  std::size_t created_since_retirement = 0;
};

class ObjectRegistry {
 public:
  explicit ObjectRegistry(std::uint16_t first_thing) : first_thing_(first_thing) {}
  // One that goes on where another one with the same first_thing was.
  ObjectRegistry(std::uint16_t first_thing, RegistryState state);
  RegistryState state() const { return {objects_, created_since_retirement_}; }
  std::uint16_t first_thing() const { return first_thing_; }

  // A new object. Ids count up; only when 65534 was given are those of retired objects used again, lowest first. Nothing when
  // all are taken.
  // `frame`: the one that it was found in or after.
  std::optional<LabelSlot> create(std::int64_t frame = 0);

  // Adds one detection to the evidence (Eq. 12). REQUIRES an id that create returned.
  void observe(LabelSlot id, const Segment& segment, std::int64_t frame);
  // Offers a detection that was observed as one of the object's best views. REQUIRES an id that create returned.
  void show(LabelSlot id, const ObjectView& view);

  // Object `from` is a part of `into`, as is known after this frame: its evidence goes there, and it is no object any more.
  // REQUIRES two different objects.
  void merge(LabelSlot from, LabelSlot into, std::int64_t frame);
  // Every object that was merged away, with its survivor; ascending.
  std::vector<std::pair<LabelSlot, LabelSlot>> merged() const;
  // What became of an object: the one that it was merged into, or itself.
  LabelSlot survivor(LabelSlot id) const;

  // The object cannot be of these classes (and of all others it can).
  void rule_out(LabelSlot id, std::set<ClassId> classes);

  // The object, which no network ever saw, is of this class; nothing is observed by it. REQUIRES class_of(id) == kUnknown.
  void assume(LabelSlot id, ClassId class_id);

  // The most probable class that is not ruled out; ties go to the lower class id. kUnknown for an object without evidence.
  ClassId class_of(LabelSlot id) const;
  // p(z, l) of Eq. 12, sorted by class id.
  std::vector<ClassProbability> probabilities(LabelSlot id) const;

  const Object* find(LabelSlot id) const;  // nullptr if there is no such object, or no longer
  std::size_t count() const { return objects_.size() - retired_; }

  // True when so many objects were created since the last retirement that it is worth looking for unused ones.
  bool wants_retirement() const { return created_since_retirement_ >= kRetireEvery; }
  // Forgets every object whose id is not in use; `in_use` is indexed by panoptic id (ids_in_use in voxel_map.h).
  void retire_unused(const std::vector<bool>& in_use);

 private:
  static constexpr std::size_t kRetireEvery = 2048;

  Object* reuse();

  std::uint16_t first_thing_;
  std::vector<Object> objects_;  // by id - first_thing_; a retired or merged one has the id kUnknown and holds no evidence
  std::size_t retired_ = 0;
  std::size_t created_since_retirement_ = 0;
};

}  // namespace panoptic
