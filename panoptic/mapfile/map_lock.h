// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The right to write a map file: one process has it at a time. Whoever only reads needs none.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <utility>

namespace panoptic {

// The lock is held until it is destroyed or its process is gone, however that ended. It stays with the file when that is
// renamed. All of SQLite's connections to the file must be closed before the lock is released: closing any descriptor of a file
// takes away the locks that SQLite has on it.
class MapLock {
 public:
  // Takes the lock. Throws Error if there is no such file, or somebody else writes it.
  explicit MapLock(const std::filesystem::path& path);
  ~MapLock();
  MapLock(MapLock&& other) noexcept : fd_(std::exchange(other.fd_, -1)), file_(std::move(other.file_)) {}
  MapLock& operator=(MapLock&&) = delete;
  MapLock(const MapLock&) = delete;
  MapLock& operator=(const MapLock&) = delete;

 private:
  using FileId = std::pair<dev_t, ino_t>;

  int fd_ = -1;
  FileId file_;
};

}  // namespace panoptic
