// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The JSON messages of docs/viewer_protocol.md. Numbers that are not finite become null, bytes that are not UTF-8 the
// replacement character.
#pragma once

#include <cstdint>
#include <string>

#include "apps/viewer/scene_history.h"
#include "apps/viewer/surface.h"

namespace panoptic {

inline constexpr int kViewerProtocol = 2;
inline constexpr std::size_t kMaxPathSent = 2000;
inline constexpr std::size_t kMaxSpansSent = 20000;
inline constexpr std::size_t kMaxTracksSent = 1000;
inline constexpr std::size_t kMaxTrackedBoxesSent = 20000;

// Facts of a server about its scene.
struct SceneFacts {
  std::string run;           // different for every start
  bool has_history = false;  // something came, went or moved
  bool grows = false;        // figures live in the newest snapshot
};
std::string scene_message(const SnapshotScene& scene, const SceneFacts& facts);
// The message `state`, with chunks newer than `since` only.
std::string state_message(const SnapshotSurface& surface, std::uint64_t since);
std::string objects_message(const Snapshot& snapshot, const LabelSet& labels);
// A history of more than a page takes is cut to the objects with the lowest ids and the longest tracks, and boxes are thinned
// evenly; the message says how many were left out.
std::string history_message(const SceneHistory& history, const LabelSet& labels);
// The text of the event `state`.
std::string event_message(const Snapshot& snapshot, const std::string& run);

}  // namespace panoptic
