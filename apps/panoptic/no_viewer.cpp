// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The program without the viewer (PANOPTIC_VIEWER=OFF): whoever asks for one is told.
#include "apps/panoptic/commands.h"
#include "apps/viewer/server.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

[[noreturn]] void needs_viewer() {
  throw Error("view: this program was built without the viewer; build it with -DPANOPTIC_VIEWER=ON");
}

}  // namespace

struct ViewerServer::State {};

PlaySource::PlaySource(std::string /*map_file*/, std::string /*why_not*/) {}
PlaySource PlaySource::of_growing_map() { needs_viewer(); }
ViewerServer::ViewerServer(const ViewerOptions& /*options*/, SnapshotScene /*scene*/, const LatestSnapshot& /*latest*/,
                           PlaySource /*play*/, SceneHistory /*history*/) {
  needs_viewer();
}
ViewerServer::~ViewerServer() = default;
std::string ViewerServer::url() const { return ""; }

ViewerOptions viewer_options_from(const Arguments& /*arguments*/) { needs_viewer(); }

int export_web(const Arguments& /*arguments*/) { needs_viewer(); }

int view(const Arguments& /*arguments*/) { needs_viewer(); }

}  // namespace panoptic
