// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The vocabulary of a map: classes ("what") and panoptic ids ("which one"), and the slots by which voxels name them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "panoptic/image.h"

namespace panoptic {

// The class of something: chair, wall. Numbers come from the label set; 0 is unknown.
enum class ClassId : std::uint16_t { kUnknown = 0 };

// The label that a voxel holds: whatever was not told apart has its class number, things have slots from
// LabelSet::first_thing() on; 0 is unknown. kNoVote is the ignore label: in a label image it marks pixels that vote for nothing
// (no depth, hidden from the colour camera, or a frame without a prediction), and no voxel ever holds it. kUnknown is a label
// like any other and votes.
enum class LabelSlot : std::uint16_t { kUnknown = 0, kNoVote = 65535 };
inline constexpr std::size_t kLabelSlots = 65536;  // the length of a table that is indexed by them

// The number of an object in the map, as users see it. Whatever was not told apart has its class number; objects have ids from
// LabelSet::first_thing() on, which count up and are never given twice in the life of a map. Slots are given anew: only an
// ObjectRegistry knows which object a slot is of.
enum class PanopticId : std::uint32_t { kUnknown = 0 };

constexpr std::uint16_t number(ClassId id) { return static_cast<std::uint16_t>(id); }
constexpr std::uint16_t number(LabelSlot slot) { return static_cast<std::uint16_t>(slot); }
constexpr std::uint32_t number(PanopticId id) { return static_cast<std::uint32_t>(id); }

struct LabelClass {
  ClassId id = ClassId::kUnknown;
  std::string name;
  bool is_thing = true;
  Rgb color;
  double max_size_m = 0;    // nothing of this class is longer; 0 = no limit
  bool is_support = false;  // has a level top that other things stand on
  bool is_mobile = false;   // moves by itself (people, animals) and is kept out of the map
};

// The classes of a map, sorted by id. Immutable once made, so any thread may read it.
class LabelSet {
 public:
  LabelSet() = default;
  // Throws Error unless ids are unique and in 1..999 and names are unique and not empty.
  LabelSet(std::string name, std::vector<LabelClass> classes);

  const std::string& name() const { return name_; }
  const std::vector<LabelClass>& classes() const { return classes_; }

  // nullptr if there is no such class (always for kUnknown).
  const LabelClass* find(ClassId id) const;
  const LabelClass* find(std::string_view name) const;

  bool is_thing(ClassId id) const;
  bool is_stuff(ClassId id) const;
  bool is_support(ClassId id) const;
  bool is_mobile(ClassId id) const;
  std::string_view name_of(ClassId id) const;  // "unknown" if there is none

  // The lowest slot and the lowest panoptic id of an object: one above the highest class id.
  std::uint16_t first_thing() const { return first_thing_; }
  bool is_object(LabelSlot slot) const { return number(slot) >= first_thing_; }
  bool is_object(PanopticId id) const { return number(id) >= first_thing_; }
  // The slot and the id of all that is of a class and was not told apart: stuff, and things without an instance. Both are the
  // class number.
  static LabelSlot of_class(ClassId id) { return static_cast<LabelSlot>(number(id)); }
  static PanopticId id_of_class(ClassId id) { return static_cast<PanopticId>(number(id)); }

 private:
  std::string name_;
  std::vector<LabelClass> classes_;
  std::uint16_t first_thing_ = 1;
};

// A label set by the name of a built-in one ("indoor", "scannet20": the files in configs/labels) or by the path of a TOML
// file: `name`, then `[[class]]` tables of `id`, `name`, `thing`, `color`. Throws Error.
LabelSet load_label_set(const std::string& name_or_path);

// A colour for an object id: far apart for neighbouring ids, the same in every run.
Rgb color_of(PanopticId id, const LabelSet& labels);

}  // namespace panoptic
