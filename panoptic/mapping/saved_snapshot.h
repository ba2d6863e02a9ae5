// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "panoptic/map_file.h"
#include "panoptic/mapping/snapshot.h"

namespace panoptic {

struct SavedSnapshot {
  SnapshotScene scene;
  std::shared_ptr<const Snapshot> snapshot;
  std::string note;  // what the file lacks because its format is older; else empty
};

// The map of a file (load_map, load_frames) as the run that wrote it looked at its end. Throws Error: no sound map.
SavedSnapshot open_snapshot(SavedMap saved, const std::vector<FrameRecord>& frames, const std::filesystem::path& path);

}  // namespace panoptic
