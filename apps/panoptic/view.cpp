// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <thread>
#include <utility>
#include <vector>

#include "apps/panoptic/commands.h"
#include "apps/panoptic/map_result.h"
#include "apps/panoptic/progress.h"
#include "apps/viewer/result_folder.h"
#include "apps/viewer/saved_page.h"
#include "apps/viewer/server.h"
#include "panoptic/map_file.h"
#include "panoptic/mapping/saved_snapshot.h"

namespace panoptic {
namespace {

// Opens a map file by way of a mapper with its state, so that the map looks as in the run that wrote it.
OpenedResult open_map_result(const std::string& path) {
  SavedMap saved = load_map(path);
  const std::vector<FrameRecord> frames = load_frames(path);
  SceneHistory history = history_of(saved, frames);
  SavedSnapshot opened = open_snapshot(std::move(saved), frames, path);
  tell_note(opened.note);
  return {std::move(opened.scene), std::move(opened.snapshot), std::move(history)};
}

}  // namespace

ViewerOptions viewer_options_from(const Arguments& arguments) {
  ViewerOptions options;
  if (!arguments.bind.empty()) options.bind = arguments.bind;
  options.port = arguments.port;
  options.token = arguments.token;
  return options;
}

int view(const Arguments& arguments) {
  watch_for_interrupt();
  const bool is_file = is_map_file(arguments.viewed);
  OpenedResult result = is_file ? open_map_result(arguments.viewed) : open_result(arguments.viewed);
  tell_note(result.note);
  const std::size_t chunks = result.snapshot->chunks.size();
  const std::size_t objects = result.snapshot->objects.size();
  LatestSnapshot latest;
  latest.publish(std::move(result.snapshot));
  PlaySource play(is_file ? arguments.viewed : "", kNoPlay);
  const ViewerServer server(viewer_options_from(arguments), std::move(result.scene), latest, std::move(play),
                            std::move(result.history));
  fmt::print("{}: {} objects, {} pieces of surface\nlook at   {}{}\nCtrl-C ends it\n", arguments.viewed, objects, chunks,
             server.url(), arguments.command == "play" ? "#play" : "");
  std::fflush(stdout);
  while (!interrupted()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  return kDone;
}

int export_web(const Arguments& arguments) {
  constexpr double kMegabyte = 1e6;
  const SavedPage saved =
      save_page(arguments.output, open_map_result(arguments.map), PlaySource(arguments.map), arguments.camera_frames);
  for (const std::string& note : saved.notes) tell_note(note);
  fmt::print("{}: {} files, {:.1f} MB, {} frames for the camera view\nlook at   {}/index.html\n", arguments.output, saved.files,
             static_cast<double>(saved.bytes) / kMegabyte, saved.frames, arguments.output);
  return kDone;
}

}  // namespace panoptic
