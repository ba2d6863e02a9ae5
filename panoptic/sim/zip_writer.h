// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Writing zip archives of files that are compressed already, such as PNG.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

struct zip;
struct zip_source;

namespace panoptic {

// Keeps the entries in memory until finish(), when the archive appears whole; without it nothing is left. The same entries give
// the same bytes: they bear no time. Not thread-safe. Everything throws Error naming the archive.
class ZipWriter {
 public:
  explicit ZipWriter(std::filesystem::path path);
  ~ZipWriter();
  ZipWriter(const ZipWriter&) = delete;
  ZipWriter& operator=(const ZipWriter&) = delete;

  void add(const std::string& entry, const std::vector<std::uint8_t>& bytes);
  void finish();

 private:
  std::filesystem::path path_;
  zip_source* bytes_ = nullptr;  // the archive in memory
  zip* archive_ = nullptr;
};

}  // namespace panoptic
