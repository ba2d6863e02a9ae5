// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The viewer's answer to each path, without the network: a fixed table of names, no file system behind it.
#pragma once

#include <atomic>
#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "apps/viewer/encode.h"
#include "apps/viewer/live_plan.h"
#include "apps/viewer/maker.h"
#include "apps/viewer/pictures.h"
#include "apps/viewer/play_source.h"
#include "apps/viewer/scene_history.h"
#include "panoptic/mapping/snapshot.h"

namespace panoptic {

struct Answer {
  int status = 200;
  std::string type;  // of the content
  std::shared_ptr<const std::string> body;
  std::string download_name;  // a file to be saved, not shown; empty = none
};

// The part of an address behind the "?".
using Query = std::multimap<std::string, std::string>;

inline constexpr std::size_t kMaxChunksAsked = 64;

// Thread-safe. `latest` must live as long.
class ViewerContent {
 public:
  ViewerContent(SnapshotScene scene, const LatestSnapshot& latest, PlaySource play = PlaySource("", kNoPlay),
                SceneHistory history = {});

  // The answer to a path below /api; status 404 for every other path, 400 for a query that is not as documented.
  // Answers are made one after the other on a thread of its own.
  Answer answer(const std::string& path, const Query& query);

  // The event of a snapshot for the event stream.
  std::string event(const Snapshot& snapshot) const;
  const LatestSnapshot& latest() const { return latest_; }

  // Lets go of snapshots and encoded bytes; they are made again when somebody asks.
  void forget();
  std::uint64_t encodings() const { return chunks_.encodings(); }

 private:
  Answer made(const std::string& path, const Query& query);
  std::shared_ptr<const SnapshotSurface> surface();
  Answer state(const Query& query);
  Answer objects(const Query& query);
  Answer chunks(const Query& query);
  Answer glb();
  Answer play(const std::string& path, const Query& query);
  const ScenePlan& plan(const Query& query);

  SnapshotScene scene_;
  const LatestSnapshot& latest_;
  SceneHistory history_;
  std::string run_;  // different for every start
  ChunkCache chunks_;
  FramePictures pictures_;
  std::mutex surface_mutex_;
  std::shared_ptr<const SnapshotSurface> surface_;  // of the newest snapshot that somebody asked for
  std::atomic<bool> is_making_glb_ = false;         // one at a time: it takes memory
  Maker glb_maker_;                                 // and time, so the others do not wait for it
  PlaySource play_;                                 // on play_maker_ alone, like the next
  LivePlan live_;                                   // of a map that grows
  Maker play_maker_;                                // a plan takes seconds
  Maker maker_;
};

}  // namespace panoptic
