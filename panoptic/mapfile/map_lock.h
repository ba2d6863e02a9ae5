// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The right to write a map file: one process has it at a time. Whoever only reads needs none.
#pragma once

#include <filesystem>

#include "panoptic/base/os.h"

namespace panoptic {

// The lock is held until it is destroyed or its process is gone, however that ended. It stays with the file when that is
// renamed. All of SQLite's connections to the file must be closed before the lock is released: closing any descriptor of a file
// takes away the locks that SQLite has on it.
class MapLock {
 public:
  // Takes the lock. Throws Error if there is no such file, or somebody else writes it.
  explicit MapLock(const std::filesystem::path& path);
  ~MapLock();
  MapLock(MapLock&& other) noexcept = default;
  MapLock& operator=(MapLock&&) = delete;
  MapLock(const MapLock&) = delete;
  MapLock& operator=(const MapLock&) = delete;

 private:
  os::File file_;
  os::FileId id_;
};

}  // namespace panoptic
