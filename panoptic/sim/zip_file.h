// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Reading zip archives: the one seam to libzip.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

struct zip;

namespace panoptic {

// Not thread-safe: one thread at a time.
class ZipFile {
 public:
  // Throws Error if the file is absent or no zip archive.
  explicit ZipFile(std::filesystem::path path);
  ~ZipFile();
  ZipFile(const ZipFile&) = delete;
  ZipFile& operator=(const ZipFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  bool contains(const std::string& entry) const;

  // The uncompressed entry. Throws Error naming archive and entry if it is absent, damaged (its checksum is verified), or
  // larger than max_bytes, which is known before memory is taken.
  std::string read(const std::string& entry, std::size_t max_bytes) const;

 private:
  std::filesystem::path path_;
  zip* archive_ = nullptr;
};

}  // namespace panoptic
