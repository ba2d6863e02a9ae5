// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The tree of frames that a bag's transforms make (TF), with each transform as it changes.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/bags/messages.h"
#include "panoptic/io/time_pairing.h"

namespace panoptic {

class TransformTree {
 public:
  void add(const PoseMessage& transform, bool is_static);
  // After the last add.
  void finish();

  bool empty() const { return edges_.empty(); }
  bool has(const std::string& frame) const;
  // From the frame up to its root, both included. Throws Error, beginning with `source`, for a frame with two parents, or a
  // circle.
  std::vector<std::string> chain(const std::string& frame, const std::string& source) const;
  // True if any transform changes.
  bool moves() const;
  // True if a transform of this chain changes. REQUIRES a frame in it.
  bool moves(const std::vector<std::string>& chain) const;
  // The pose of the chain's first frame in its last, where all of its transforms are known.
  std::optional<Eigen::Matrix4d> pose(const std::vector<std::string>& chain, double time_s) const;
  // Nothing if the frames are not connected by transforms that never change.
  std::optional<Eigen::Matrix4d> fixed(const std::string& target, const std::string& source) const;
  std::vector<std::string> frames() const;  // sorted

 private:
  struct Edge {
    std::string parent;
    std::string other_parent;  // empty: there is none
    bool is_static = false;
    std::vector<PoseSample> poses;  // of the child in the parent; one if it is static
  };

  std::map<std::string, Edge> edges_;  // by child
};

}  // namespace panoptic
