// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Objects as rows of a map file, in and out.
#pragma once

#include "panoptic/base/sqlite.h"
#include "panoptic/map/label_extents.h"
#include "panoptic/objects.h"

namespace panoptic {

// The columns of an object's row.
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
  // Forgets the rows of the last write: they are not in the file after all.
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

// Numbers of ids and of slots that were ever given.
struct GivenCounts {
  std::uint32_t ids = 0;
  std::uint16_t slots = 0;
};

// Reads the tables of a file of that format; the caller fills in `next_id` and everything else that they do not hold. Throws
// Error for contents that cannot be.
RegistryState read_objects(Database& database, std::int64_t format, std::uint16_t first_thing, GivenCounts given);

}  // namespace panoptic
