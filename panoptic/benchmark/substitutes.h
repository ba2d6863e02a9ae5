// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Stages of a mapper replaced by what a simulation knows, for the error budget.
#pragma once

#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "panoptic/benchmark/vote_map.h"
#include "panoptic/image.h"
#include "panoptic/mapping/mapper_parts.h"
#include "panoptic/mesh.h"

namespace panoptic {

struct Substitutes {
  bool tracking = false;  // a mask belongs to the true thing that it covers most of
  bool storage = false;   // a voxel counts every vote for every label instead of keeping one label
};

// A mapper with substitutes, without regularizer and object maintenance. Nothing replaced: the same map as without them.
class SubstituteMapper {
 public:
  SubstituteMapper(Options options, LabelSet labels, Substitutes substitutes);
  ~SubstituteMapper() = default;
  SubstituteMapper(const SubstituteMapper&) = delete;  // its stages know where it is
  SubstituteMapper& operator=(const SubstituteMapper&) = delete;

  // REQUIRES depth and colour of one camera, as simulations have them.
  Outcome add(const Frame& frame, const Segmentation& segmentation, const Image<std::uint16_t>& true_instance);

  Mesh mesh();
  const PanopticMap& map() const { return mapper_->map(); }

 private:
  Association associate(const FrameToLabel& to_label, PanopticMap& map);
  LabelSlot object_of(std::uint16_t true_instance, ObjectRegistry& objects);

  Substitutes substitutes_;
  const Image<std::uint16_t>* true_instance_ = nullptr;  // of the frame that is being added
  std::unique_ptr<MapperParts> mapper_;
  VoteMap votes_;
  std::vector<LabelSlot> labels_;
  std::vector<LabelSlot> segment_ids_;
  std::vector<std::uint32_t> segment_areas_px_;
  std::unordered_map<std::uint16_t, LabelSlot> object_of_instance_;
};

}  // namespace panoptic
