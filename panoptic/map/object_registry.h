// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The things of the map: which class each probably is (Eq. 12), and when it was seen. Evidence is kept per object, never per
// voxel. Not thread-safe: one writer, no readers meanwhile.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "panoptic/data/labels.h"
#include "panoptic/data/segmentation.h"

namespace panoptic {

struct Object {
  PanopticId id = PanopticId::kUnknown;
  std::int64_t first_frame = 0;
  std::int64_t last_frame = 0;
  std::uint64_t observations = 0;
  double score_sum = 0;                // denominator of Eq. 12
  std::map<ClassId, double> evidence;  // its numerator per class: sum of score * p(class)
};

class ObjectRegistry {
 public:
  explicit ObjectRegistry(std::uint16_t first_thing) : first_thing_(first_thing) {}

  // The next free id; nothing when all 16-bit ids are used up (65534 is the last).
  std::optional<PanopticId> create();

  // Adds one detection to the evidence (Eq. 12). REQUIRES an id that create returned.
  void observe(PanopticId id, const Segment& segment, std::int64_t frame);

  // The most probable class; ties go to the lower class id. kUnknown for an object without evidence.
  ClassId class_of(PanopticId id) const;
  // p(z, l) of Eq. 12, sorted by class id.
  std::vector<ClassProbability> probabilities(PanopticId id) const;

  const Object* find(PanopticId id) const;                         // nullptr if there is no such object
  const std::vector<Object>& objects() const { return objects_; }  // ascending id

 private:
  std::uint16_t first_thing_;
  std::vector<Object> objects_;
};

}  // namespace panoptic
