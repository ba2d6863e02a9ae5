// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Shows a map in web browsers while it grows: a small HTTP server that reads snapshots (docs/viewer_protocol.md).
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "panoptic/session/snapshot.h"

namespace panoptic {

struct ViewerOptions {
  std::string bind = "127.0.0.1";  // any other than a loopback address needs a token
  std::uint16_t port = 8060;       // 0 = any that is free
  std::string token;               // what browsers must show; empty = none (loopback only)
};

// Serves from threads of its own, from construction to destruction. Only ever reads `latest`, so a slow or vanished browser
// never slows mapping. Construction throws Error: the address cannot be bound, a token is missing, the page was not built.
class ViewerServer {
 public:
  ViewerServer(const ViewerOptions& options, Scene scene, const LatestSnapshot& latest);
  ~ViewerServer();  // ends every connection
  ViewerServer(const ViewerServer&) = delete;
  ViewerServer& operator=(const ViewerServer&) = delete;

  std::string url() const;  // "http://127.0.0.1:8060/", with ?token=... where one is needed

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace panoptic
