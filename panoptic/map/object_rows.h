// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Objects as rows of a map file, in and out.
#pragma once

#include "panoptic/map/label_extents.h"
#include "panoptic/map/object_registry.h"
#include "panoptic/map/sqlite.h"

namespace panoptic {

// What the row of an object holds.
struct ObjectRow {
  Object object;
  ClassId class_id = ClassId::kUnknown;
  double probability = 0;  // of that class, Eq. 12
  LabelExtent extent;

  bool operator==(const ObjectRow&) const = default;
};

using ObjectRows = std::map<PanopticId, ObjectRow>;
ObjectRows object_rows(const ObjectRegistry& objects, const LabelExtents& extents);

// Keeps the tables `objects`, `merged` and `left_slots` as given; only rows that differ from those of the last time are written.
class ObjectTableWriter {
 public:
  ObjectTableWriter(Database& database, double voxel_size_m);
  void write(ObjectRows rows, const RegistryState& registry);
  // The rows of the last write are not in the file after all.
  void forget() { written_.reset(); }

 private:
  struct Written {
    ObjectRows rows;
    std::vector<MergedObject> merged;
    std::vector<LeftSlot> left;
  };

  void put(PanopticId id, const ObjectRow& row);
  void put_merged(const std::vector<MergedObject>& merged, const std::vector<MergedObject>& before);
  void put_left(const std::vector<LeftSlot>& left);

  Database& database_;
  double voxel_size_m_;
  Statement put_;
  Statement remove_;
  std::optional<Written> written_;
};

// How many of each were given by then, in all.
struct GivenCounts {
  std::uint32_t ids = 0;
  std::uint16_t slots = 0;
};

// The tables of a file of that format; `next_id` and what they say nothing of is filled in by the caller. Throws Error for what
// cannot be.
RegistryState read_objects(Database& database, std::int64_t format, std::uint16_t first_thing, GivenCounts given);

}  // namespace panoptic
