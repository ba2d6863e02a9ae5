// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Shows a map in web browsers while it grows: a small HTTP server that reads snapshots (docs/viewer_protocol.md).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "apps/viewer/play_source.h"
#include "apps/viewer/scene_history.h"
#include "panoptic/mapping/snapshot.h"

namespace panoptic {

inline constexpr std::uint16_t kDefaultViewerPort = 8060;

struct ViewerOptions {
  std::string bind = "127.0.0.1";     // any other than a loopback address needs a token
  std::optional<std::uint16_t> port;  // empty: kDefaultViewerPort or the next one that is free; 0: any that is free
  std::string token;                  // what browsers must show, 8 to 128 of A-Z a-z 0-9 - . _ ~; empty = none (loopback only)
};

// Serves from threads of its own, from construction to destruction. Only ever reads `latest`, so a slow or vanished browser
// never slows mapping. Construction throws Error: the address cannot be bound, a token is missing or malformed.
class ViewerServer {
 public:
  ViewerServer(const ViewerOptions& options, SnapshotScene scene, const LatestSnapshot& latest,
               PlaySource play = PlaySource("", kNoPlay), SceneHistory history = {});
  ~ViewerServer();  // ends every connection
  ViewerServer(const ViewerServer&) = delete;
  ViewerServer& operator=(const ViewerServer&) = delete;

  // Serves on until no browser has asked for anything for two seconds, so that those who watch get what came last; half a minute
  // at most, and no longer than `wanted` says.
  void finish(const std::function<bool()>& wanted) const;

  std::string url() const;  // "http://127.0.0.1:8060/", with ?token=... where one is needed

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace panoptic
