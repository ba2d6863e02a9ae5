// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Questions to a map: where are the chairs, what is in this box, what is nearest to this point, what is at this point.
//   const SavedMap saved = load_map("map.panoptic");
//   const MapQuery query(saved.map);
//   for (const FoundObject& chair : query.of_class("chair")) ...
// Metres, world of the recording's poses.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/labels.h"
#include "panoptic/map.h"
#include "panoptic/map_file.h"

namespace panoptic {

struct FoundObject {
  PanopticId id = PanopticId::kUnknown;
  LabelSlot slot = LabelSlot::kUnknown;  // by which voxels name it
  ClassId class_id = ClassId::kUnknown;
  double probability = 0;  // of that class, Eq. 12; 0 without evidence
  ExtentBox box{};         // around its surface voxels, and their mean
  std::uint64_t voxels = 0;
  std::uint64_t observations = 0;
  std::int64_t first_frame = 0;
  std::int64_t last_frame = 0;
};

struct NearObject {
  FoundObject object;
  double distance_m = 0;  // from the point to the centre of the object's nearest surface voxel
};

// The contents of the map at a point that was observed.
struct PointAnswer {
  PanopticId id = PanopticId::kUnknown;
  ClassId class_id = ClassId::kUnknown;
  float distance_m = 0;   // to the nearest surface, signed: positive in front of it, at most the truncation
  float weight = 0;       // of the observations: W^D of Eq. 7, a sum of 1/z^2, 1/m^2
  float label_share = 0;  // of all that was voted, 0 to 1: how sure it is
};

// When an object was there. Times are seconds of the recording.
struct ObjectSpan {
  PanopticId id = PanopticId::kUnknown;
  ClassId class_id = ClassId::kUnknown;
  ExtentBox box{};  // of one that is gone: its last place
  double first_s = 0;
  std::optional<double> gone_s;                  // when it was known to be gone
  bool appeared = false;                         // it came to a place that had been free
  PanopticId moved_from = PanopticId::kUnknown;  // the object that it was before, or that it is now; kUnknown: none
  PanopticId moved_to = PanopticId::kUnknown;
};

// The objects of a map and those that are gone, ascending by id. `frames`: of its file (load_frames).
std::vector<ObjectSpan> object_spans(const PanopticMap& map, const std::vector<FrameRecord>& frames);
// Those that were seen by that time and not yet known to be gone.
std::vector<ObjectSpan> present_at(const std::vector<ObjectSpan>& spans, double time_s);
// Those that came, were moved, or were found to be gone after that time.
std::vector<ObjectSpan> changed_since(const std::vector<ObjectSpan>& spans, double time_s);

// Answers for a map as it is when the query is made: no function may run while the map changes, nor after it has changed (make a
// new query then). The map must outlive it. const functions may be called from several threads.
class MapQuery {
 public:
  explicit MapQuery(const PanopticMap& map);

  // Objects with surface, ascending by id.
  const std::vector<FoundObject>& objects() const { return objects_; }
  // The objects of a class; "unknown" gives those of no known class. Throws Error naming the classes there are if there is none
  // of that name.
  std::vector<FoundObject> of_class(std::string_view name) const;
  // Objects whose boxes share a point with this one. REQUIRES min <= max along every axis.
  std::vector<FoundObject> in_box(const Vec3d& min_m, const Vec3d& max_m) const;
  // The nearest objects, at most `count`, the nearest first; ties to the lower id. Nothing for a point that is not finite.
  std::vector<NearObject> nearest(const Vec3d& point_m, std::size_t count) const;
  // The contents of the map at the point; nothing where nothing was observed.
  std::optional<PointAnswer> at(const Vec3d& point_m) const;

 private:
  const PanopticMap& map_;
  std::vector<FoundObject> objects_;
};

}  // namespace panoptic
