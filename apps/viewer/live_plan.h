// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Plans of a map that grows, for the figures in it (docs/viewer_protocol.md): made from the newest snapshots when somebody asks.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "panoptic/mapping/snapshot.h"
#include "panoptic/planning/scene_plan.h"
#include "panoptic/profile.h"

namespace panoptic {

// One thread at a time, so that never two plans are made at once. Reads snapshots alone: mapping waits for nothing here. `scene`
// and `latest` must live as long.
class LivePlan {
 public:
  static constexpr double kEvery_s = 0.9;  // from begin to begin: snapshots come once a second

  LivePlan(const SnapshotScene& scene, const LatestSnapshot& latest) : scene_(scene), latest_(latest) {}

  // JSON: the newest plan, made anew if there is a newer snapshot and the last time began long enough ago: kEvery_s, and twice as
  // long as planning took, so that nobody plans for more than half of the time.
  std::string newest();

  // The newest plan or the one before it. Throws Error if it is neither, or none.
  const ScenePlan& of(std::uint64_t revision) const;

 private:
  struct Made {
    std::uint64_t revision = 0;  // of the snapshot; 0: none
    ScenePlan plan;
  };
  void renew();

  const SnapshotScene& scene_;
  const LatestSnapshot& latest_;
  Made newest_;
  Made before_;                                    // some browser may be fetching it
  std::uint64_t looked_at_ = 0;                    // the newest snapshot that was planned from
  bool is_last_ = false;                           // no newer one will come
  std::string why_not_ = "nothing is mapped yet";  // of the newest snapshot; empty: it has a plan
  std::optional<Stopwatch> since_;                 // the last time began
  double took_s_ = 0;
};

}  // namespace panoptic
