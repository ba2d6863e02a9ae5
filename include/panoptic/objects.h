// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The objects of a map: which class each probably is (Eq. 12), why the map takes it for that, and when it was seen. Evidence is
// kept per object, never per voxel, in bounded memory. Networks also find things that never get hold of a voxel; those are
// retired from time to time, so that the registry does not grow with the number of frames. Not thread-safe: one writer, no
// readers meanwhile.
//
// An object has an id, which users see, and a slot, by which voxels name it. Ids are never given twice. There are fewer slots
// than objects in a long life: the slot of an object that is no more is given anew when nothing names it any more.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/labels.h"
#include "panoptic/segmentation.h"

namespace panoptic {

// Pixels u0 <= u < u1, v0 <= v < v1; empty where u0 >= u1.
struct PixelBox {
  int u0 = 0;
  int v0 = 0;
  int u1 = 0;
  int v1 = 0;

  bool operator==(const PixelBox&) const = default;
};

// One detection of an object.
struct ObjectView {
  std::int64_t frame = 0;
  ClassId class_id = ClassId::kUnknown;  // what it was taken for
  float score = 0;
  std::uint32_t visible_px = 0;  // of the depth image
  PixelBox box;                  // of the mask, in the colour image

  bool operator==(const ObjectView&) const = default;
};

// The detections with the largest score * visible_px, best first; ties go to the earlier frame.
class BestViews {
 public:
  static constexpr std::size_t kMost = 3;

  // True if add would keep it.
  bool wants(const ObjectView& view) const;
  void add(const ObjectView& view);
  void merge(const BestViews& other);
  std::span<const ObjectView> views() const { return {views_.data(), count_}; }

  bool operator==(const BestViews&) const = default;

 private:
  std::array<ObjectView, kMost> views_;
  std::size_t count_ = 0;
};

// Votes per class in bins of 2^k frames, k as small as at most kMostBins bins that hold votes allow. Bin n holds the frames
// n * 2^k to (n + 1) * 2^k - 1, whenever the object was first seen, so that histories can be merged.
class VoteHistory {
 public:
  static constexpr std::size_t kMostBins = 16;
  struct Bin {
    std::int64_t number = 0;
    std::map<ClassId, std::uint64_t> votes;

    bool operator==(const Bin&) const = default;
  };

  VoteHistory() = default;
  // Restores what bins() and log2_frames_per_bin() returned. REQUIRES what they guarantee.
  VoteHistory(std::vector<Bin> bins, int log2_frames_per_bin)
      : bins_(std::move(bins)), log2_frames_per_bin_(log2_frames_per_bin) {}

  void add(std::int64_t frame, ClassId class_id);
  void merge(const VoteHistory& other);

  const std::vector<Bin>& bins() const { return bins_; }  // ascending, none empty
  static constexpr int kMostLog2 = 60;                    // 16 bins of that width hold every frame number there is
  int log2_frames_per_bin() const { return log2_frames_per_bin_; }
  std::uint64_t frames_per_bin() const { return std::uint64_t{1} << log2_frames_per_bin_; }
  std::int64_t first_frame(const Bin& bin) const { return bin.number * static_cast<std::int64_t>(frames_per_bin()); }

  bool operator==(const VoteHistory&) const = default;

 private:
  Bin& bin_of(std::int64_t number);
  void widen();

  std::vector<Bin> bins_;
  int log2_frames_per_bin_ = 0;  // at most kMostLog2
};

// Another object that turned out to be a part of this one, and the frame after which that was found.
struct ObjectPart {
  PanopticId id = PanopticId::kUnknown;
  std::int64_t frame = 0;

  bool operator==(const ObjectPart&) const = default;
};

// The number of parts that were found, and the latest of them.
class PartHistory {
 public:
  static constexpr std::size_t kMost = 64;

  PartHistory() = default;
  // Restores what count() and latest() returned. REQUIRES what they guarantee.
  PartHistory(std::uint64_t count, std::vector<ObjectPart> latest) : count_(count), latest_(std::move(latest)) {}

  void add(const ObjectPart& part);
  // Takes over the parts of an object that became a part itself.
  void merge(const PartHistory& other);

  std::uint64_t count() const { return count_; }
  const std::vector<ObjectPart>& latest() const { return latest_; }  // in the order in which they were added, at most kMost

  bool operator==(const PartHistory&) const = default;

 private:
  void append(const std::vector<ObjectPart>& parts);

  std::uint64_t count_ = 0;
  std::vector<ObjectPart> latest_;
};

// In metres, world: the box around an object's surface voxels (their outer faces), and their mean.
struct ExtentBox {
  Vec3d min_m;
  Vec3d max_m;
  Vec3d center_m;
};

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
  // Ascending by id. `into` is never itself merged into another. Its object may be gone; while it is there, it counts its parts.
  std::vector<MergedObject> merged;
  PanopticId next_id = PanopticId::kUnknown;
  std::uint64_t refused = 0;  // objects that could not be created
  std::size_t created_since_retirement = 0;

  bool operator==(const RegistryState&) const = default;
};

class ObjectRegistry {
 public:
  explicit ObjectRegistry(std::uint16_t first_thing);
  // Goes on from the state of a registry with the same first_thing.
  ObjectRegistry(std::uint16_t first_thing, RegistryState state);
  const RegistryState& state() const { return state_; }
  std::uint16_t first_thing() const { return first_thing_; }
  PanopticId next_id() const { return state_.next_id; }  // of the next object; all ids given so far are below

  // Makes a new object and returns its slot. Slots count up; only when 65534 was given are free ones given anew, lowest first.
  // Nothing when all are taken, which refused() counts. `frame`: the one that the object was found in or after.
  std::optional<LabelSlot> create(std::int64_t frame = 0);
  std::uint64_t refused() const { return state_.refused; }
  // Makes an object anew under an id that was given before. Nothing when there is no slot. REQUIRES an id of an object that is no
  // more, or of another registry, below next_id.
  std::optional<LabelSlot> recreate(PanopticId id, std::int64_t frame, PartHistory parts = {});

  // Adds one detection to the evidence (Eq. 12). REQUIRES the slot of an object.
  void observe(LabelSlot slot, const Segment& segment, std::int64_t frame);
  // Offers a detection that was observed as one of the object's best views. REQUIRES the slot of an object.
  void show(LabelSlot slot, const ObjectView& view);

  // Makes object `from` a part of `into`, as was found after this frame: its evidence goes there, and it is no object any more.
  // No voxel may be given its slot from now on. REQUIRES two different objects.
  void merge(LabelSlot from, LabelSlot into, std::int64_t frame);
  // The same for an id that has no object now.
  void merge_absent(PanopticId from, LabelSlot into, std::int64_t frame);
  // Every object that was merged away, ever, with its survivor; ascending.
  const std::vector<MergedObject>& merged() const { return state_.merged; }
  // The object that this one was merged into, or itself.
  PanopticId survivor(PanopticId id) const;
  // The same by slots, as long as something may name the slot (retire_unused): the survivor's slot, or itself.
  LabelSlot survivor(LabelSlot slot) const;

  // Says that the object cannot be of these classes, and can be of all others.
  void rule_out(LabelSlot slot, std::set<ClassId> classes);

  // Gives a class to an object that no network ever saw; this observes nothing. REQUIRES class_of(slot) == kUnknown.
  void assume(LabelSlot slot, ClassId class_id);

  // The most probable class that is not ruled out; ties go to the lower class id. kUnknown for an object without evidence.
  ClassId class_of(LabelSlot slot) const;
  // p(z, l) of Eq. 12, sorted by class id.
  std::vector<ClassProbability> probabilities(LabelSlot slot) const;

  // The object with this slot; nullptr if there is none, or none any more.
  const Object* find(LabelSlot slot) const;
  const Object* find(PanopticId id) const;
  std::size_t count() const { return slot_of_.size(); }

  // The object that a slot names: the one that has it, or the one that had it last as long as something may name it. kUnknown if
  // there is none, and for slots of classes.
  PanopticId named_by(LabelSlot slot) const;
  // The id that users see where voxels hold this slot: the number of a class, or the id of the object that has the slot.
  PanopticId id_of(LabelSlot slot) const;

  // True when so many objects were created since the last retirement that it is worth looking for unused ones.
  bool wants_retirement() const { return state_.created_since_retirement >= kRetireEvery; }
  // Forgets every object that no voxel holds, and frees the slots of objects that are no more where nothing else names them
  // either. Both arguments are by slot (kLabelSlots entries): ids_in_use of voxel_map.h, and slots that must not be given anew
  // for other reasons, if any.
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
