// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Opens a finished result (docs/outputs.md) as a snapshot for viewers.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "apps/viewer/scene_history.h"
#include "panoptic/mapping/snapshot.h"
#include "panoptic/mesh.h"

namespace panoptic {

struct OpenedResult {
  SnapshotScene scene;                       // without confidence: a mesh does not hold it
  std::shared_ptr<const Snapshot> snapshot;  // revision 1, finished, no frame
  SceneHistory history = {};
  std::string note = {};  // about a part that could not be read; empty otherwise
};

// Throws Error as run_files.h does, and if the files do not fit one another.
OpenedResult open_result(const std::filesystem::path& folder);

// The mesh in chunks: each triangle goes to the block of the cell that it lies in, and takes its vertices along, so those at
// borders are in several chunks. Ascending blocks. Throws Error if a triangle is larger than the voxels allow or lies farther
// away than blocks can be numbered.
std::vector<SnapshotChunk> cut_into_chunks(const Mesh& mesh, double voxel_size_m);

}  // namespace panoptic
