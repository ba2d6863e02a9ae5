// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A mapping run in which stages can be replaced by what a simulation knows, for the error budget. Nothing replaced: the same
// map as Session's, bit for bit, without the regularizer.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "panoptic/benchmark/vote_map.h"
#include "panoptic/data/mesh.h"
#include "panoptic/fusion/integrator.h"
#include "panoptic/fusion/label_tracker.h"
#include "panoptic/fusion/mesher.h"
#include "panoptic/fusion/registration.h"
#include "panoptic/map/object_registry.h"
#include "panoptic/map/voxel_map.h"
#include "panoptic/session/options.h"
#include "panoptic/sim/simulation.h"

namespace panoptic {

struct Substitutes {
  bool tracking = false;  // a mask belongs to the true thing that it covers most of
  bool storage = false;   // a voxel counts every vote for every label instead of keeping one label
};

class SubstituteSession {
 public:
  SubstituteSession(const Options& options, LabelSet labels, Substitutes substitutes);

  // REQUIRES a usable frame and depth and colour of one camera, as simulations have them.
  void add(const Frame& frame, const Segmentation& segmentation, const Image<std::uint16_t>& true_instance);

  Mesh mesh();
  const PanopticMap& map() const { return map_; }

 private:
  const std::vector<LabelSlot>& assign_truth(const RegisteredFrame& registered, std::span<const Segment> segments,
                                             const Image<std::uint16_t>& true_instance, std::int64_t frame);
  LabelSlot object_of(std::uint16_t true_instance);

  Substitutes substitutes_;
  PanopticMap map_;
  Registration registration_;
  LabelTracker tracker_;
  Integrator integrator_;
  Mesher mesher_;
  VoteMap votes_;
  std::vector<LabelSlot> reference_;
  std::vector<LabelSlot> assigned_;
  std::unordered_map<std::uint16_t, LabelSlot> object_of_instance_;
};

}  // namespace panoptic
