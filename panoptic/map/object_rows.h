// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Objects as rows of a map file, in and out.
#pragma once

#include "panoptic/map/label_extents.h"
#include "panoptic/map/object_registry.h"
#include "panoptic/map/sqlite.h"

namespace panoptic {

// What the row of an object holds. Of an object that was merged away, only `object.merged_into` counts.
struct ObjectRow {
  Object object;
  ClassId class_id = ClassId::kUnknown;
  double probability = 0;  // of that class, Eq. 12
  LabelExtent extent;

  bool operator==(const ObjectRow&) const = default;
};

// Every object that is, and every one that was merged into another.
std::map<LabelSlot, ObjectRow> object_rows(const ObjectRegistry& objects, const LabelExtents& extents);

// Keeps the table `objects` as given; only rows that differ from those of the last time are written.
class ObjectTableWriter {
 public:
  ObjectTableWriter(Database& database, double voxel_size_m);
  void write(std::map<LabelSlot, ObjectRow> rows);
  // The rows of the last write are not in the file after all.
  void forget() { written_.reset(); }

 private:
  void put(LabelSlot id, const ObjectRow& row);

  double voxel_size_m_;
  Statement put_;
  Statement remove_;
  Statement clear_;
  std::optional<std::map<LabelSlot, ObjectRow>> written_;
};

// `count`: how many ids were given by then. Throws Error for what cannot be.
std::vector<Object> read_objects(Database& database, std::uint16_t first_thing, std::size_t count);

}  // namespace panoptic
