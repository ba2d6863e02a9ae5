// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The things of the map: which class each probably is (Eq. 12), and when it was seen. Evidence is kept per object, never per
// voxel. Networks also find things that never get hold of a voxel; those are retired from time to time, so that the registry
// does not grow with the number of frames. Not thread-safe: one writer, no readers meanwhile.
//
// An object has an id, which users see, and a slot, by which voxels name it. Ids are never given twice. There are fewer slots
// than objects in a long life: the slot of an object that is no more is given anew when nothing names it any more.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

#include "panoptic/data/labels.h"
#include "panoptic/data/segmentation.h"
#include "panoptic/map/object_evidence.h"

namespace panoptic {

struct Object {
  PanopticId id = PanopticId::kUnknown;
  LabelSlot slot = LabelSlot::kUnknown;
  std::int64_t first_frame = 0;  // in which it was seen; without observations, after which it was made
  std::int64_t last_frame = 0;
  std::uint64_t observations = 0;
  double score_sum = 0;                // denominator of Eq. 12
  std::map<ClassId, double> evidence;  // its numerator per class: sum of score * p(class)
  std::set<ClassId> ruled_out;         // classes that it cannot be, whatever the evidence
  VoteHistory votes;                   // the class of each observation
  BestViews best_views;
  PartHistory parts;

  bool operator==(const Object&) const = default;
};

// Adds what was observed of one object to another, as if both had been one all along. Id, slot, parts and what is ruled out stay.
void add_observations(const Object& from, Object& into);

// An object that is no more, and the one that it turned out to be a part of.
struct MergedObject {
  PanopticId id = PanopticId::kUnknown;
  PanopticId into = PanopticId::kUnknown;

  bool operator==(const MergedObject&) const = default;
};

// A slot that something may still name by an object that is no more.
struct LeftSlot {
  LabelSlot slot = LabelSlot::kUnknown;
  PanopticId id = PanopticId::kUnknown;  // of that object

  bool operator==(const LeftSlot&) const = default;
};

// Everything that a registry knows, to save it and to go on from there.
struct RegistryState {
  std::vector<Object> objects;  // by slot - first_thing; where no object has the slot, one of id kUnknown without evidence
  std::vector<LeftSlot> left;   // ascending by slot
  // Ascending by id. `into` is itself no merged one, but it may be gone; as long as it is there it counts its parts.
  std::vector<MergedObject> merged;
  PanopticId next_id = PanopticId::kUnknown;
  std::uint64_t refused = 0;  // objects that could not be created
  std::size_t created_since_retirement = 0;

  bool operator==(const RegistryState&) const = default;
};

class ObjectRegistry {
 public:
  explicit ObjectRegistry(std::uint16_t first_thing);
  // One that goes on where another one with the same first_thing was.
  ObjectRegistry(std::uint16_t first_thing, RegistryState state);
  const RegistryState& state() const { return state_; }
  std::uint16_t first_thing() const { return first_thing_; }
  PanopticId next_id() const { return state_.next_id; }  // of the next object; all ids given so far are below

  // A new object, by its slot. Slots count up; only when 65534 was given are free ones given anew, lowest first. Nothing when all
  // are taken, which refused() counts.
  // `frame`: the one that it was found in or after.
  std::optional<LabelSlot> create(std::int64_t frame = 0);
  std::uint64_t refused() const { return state_.refused; }

  // Adds one detection to the evidence (Eq. 12). REQUIRES the slot of an object.
  void observe(LabelSlot slot, const Segment& segment, std::int64_t frame);
  // Offers a detection that was observed as one of the object's best views. REQUIRES the slot of an object.
  void show(LabelSlot slot, const ObjectView& view);

  // Object `from` is a part of `into`, as is known after this frame: its evidence goes there, and it is no object any more. No
  // voxel may be given its slot from now on. REQUIRES two different objects.
  void merge(LabelSlot from, LabelSlot into, std::int64_t frame);
  // Every object that was merged away, ever, with its survivor; ascending.
  const std::vector<MergedObject>& merged() const { return state_.merged; }
  // What became of an object: the one that it was merged into, or itself.
  PanopticId survivor(PanopticId id) const;
  // The same by slots, as long as something may name the slot (retire_unused): the survivor's slot, or itself.
  LabelSlot survivor(LabelSlot slot) const;

  // The object cannot be of these classes (and of all others it can).
  void rule_out(LabelSlot slot, std::set<ClassId> classes);

  // The object, which no network ever saw, is of this class; nothing is observed by it. REQUIRES class_of(slot) == kUnknown.
  void assume(LabelSlot slot, ClassId class_id);

  // The most probable class that is not ruled out; ties go to the lower class id. kUnknown for an object without evidence.
  ClassId class_of(LabelSlot slot) const;
  // p(z, l) of Eq. 12, sorted by class id.
  std::vector<ClassProbability> probabilities(LabelSlot slot) const;

  // nullptr if there is no such object, or no longer.
  const Object* find(LabelSlot slot) const;
  const Object* find(PanopticId id) const;
  std::size_t count() const { return slot_of_.size(); }

  // The object that a slot names: the one that has it, or the one that had it last as long as something may name it. kUnknown if
  // there is none, and for slots of classes.
  PanopticId named_by(LabelSlot slot) const;
  // What users see where voxels hold this slot: the number of a class, or the id of an object that is.
  PanopticId id_of(LabelSlot slot) const;

  // True when so many objects were created since the last retirement that it is worth looking for unused ones.
  bool wants_retirement() const { return state_.created_since_retirement >= kRetireEvery; }
  // Forgets every object that no voxel holds, and frees the slots of objects that are no more where nothing else names them
  // either. Both by slot (kLabelSlots entries): ids_in_use of voxel_map.h, and what else must not be given anew, if anything.
  void retire_unused(const std::vector<bool>& in_voxels, const std::vector<bool>& elsewhere = {});

 private:
  static constexpr std::size_t kRetireEvery = 2048;

  Object& at(LabelSlot slot);
  const LeftSlot* find_left(LabelSlot slot) const;
  void leave(Object& object);
  std::optional<std::size_t> free_place();

  std::uint16_t first_thing_;
  RegistryState state_;
  std::unordered_map<PanopticId, LabelSlot> slot_of_;  // of the objects that are
  std::size_t free_from_ = 0;                          // in state_.objects: no place below is free
};

}  // namespace panoptic
