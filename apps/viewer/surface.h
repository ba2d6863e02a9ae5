// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The surface of a snapshot with its chunks looked up by block, so that chunks can be smooth across their borders.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "panoptic/mapping/snapshot.h"
#include "panoptic/mesh.h"

namespace panoptic {

// Immutable, so any thread may read it. Keeps the snapshot alive.
class SnapshotSurface {
 public:
  explicit SnapshotSurface(std::shared_ptr<const Snapshot> snapshot);

  const Snapshot& snapshot() const { return *snapshot_; }

  static constexpr std::size_t kNoChunk = ~std::size_t{0};
  std::size_t find(BlockIndex index) const;  // its place in snapshot().chunks, or kNoChunk

  // The version of a chunk as a viewer sees it. Normals at its border depend on the chunks around, so this is the newest of its
  // own version and of theirs.
  std::uint64_t version(std::size_t chunk) const { return versions_[chunk]; }

  // Unit normals of the chunk's vertices. A vertex on the border has the same one in every chunk that has it.
  std::vector<Vec3f> normals(std::size_t chunk) const;

  // Everything as one mesh with shared vertices.
  Mesh assemble(const LabelSet& labels) const;

 private:
  std::shared_ptr<const Snapshot> snapshot_;
  std::unordered_map<std::uint64_t, std::size_t> chunk_at_;  // by packed block index
  std::vector<std::uint64_t> versions_;
};

}  // namespace panoptic
