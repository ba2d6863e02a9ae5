// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Files, whole or not at all. Reading checks sizes before memory is taken.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "panoptic/base/os.h"
#include "panoptic/error.h"

namespace panoptic {

// The system will not give or take a file (disk full or failing, no permission), as opposed to a file that holds nonsense.
class FileError : public Error {
 public:
  using Error::Error;
};

// The whole file. Throws FileError if it is absent or unreadable, Error if it is not a regular file or larger than max_bytes.
std::string read_file(const std::filesystem::path& path, std::uintmax_t max_bytes = std::uintmax_t{1} << 30);

// Where a file that will be called `path` is written first: beside it, a name that no other process uses.
std::filesystem::path partial_beside(const std::filesystem::path& path);

// Writes beside the target under a temporary name, syncs and renames, so that the final name never shows a partial
// file and an older file survives a failure. Throws FileError (disk full, no permission ...) and removes the temporary file.
void write_file(const std::filesystem::path& path, std::string_view bytes);
void write_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);

// The same for a file that is written piece by piece: its final name appears with commit(), and without it nothing is left.
// Every call throws FileError where the disk takes no more. Not thread-safe.
class PartialFile {
 public:
  explicit PartialFile(std::filesystem::path path);
  ~PartialFile();
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;

  void append(std::string_view bytes);
  void overwrite(std::uint64_t offset, std::string_view bytes);  // REQUIRES that so many bytes were appended before
  void commit();

 private:
  [[noreturn]] void fail(int error) const;

  std::filesystem::path path_;
  std::filesystem::path partial_;
  os::File file_;
  std::uint64_t size_ = 0;
};

// Moves what is called `from` to the name `to`, at once or not at all. Throws FileError.
void rename_file(const std::filesystem::path& from, const std::filesystem::path& to);
// The same, but false if the name is taken: of several who try it, also in other processes, one succeeds.
[[nodiscard]] bool rename_to_new(const std::filesystem::path& from, const std::filesystem::path& to);

// Creates the folder and its parents and proves that files can be written there. Throws FileError otherwise.
void require_writable_folder(const std::filesystem::path& folder);

// True if there is anything of this name (be it a link to nowhere), a regular file, a folder (or a link to one). Throw
// FileError where that cannot be told: a file that the disk fails to show must not be taken for absent.
bool is_there(const std::filesystem::path& path);
bool is_file(const std::filesystem::path& path);
bool is_folder(const std::filesystem::path& path);

// The names in a folder, sorted; none if there is no such folder. Throws FileError rather than leave some out.
std::vector<std::string> names_in_folder(const std::filesystem::path& folder);

}  // namespace panoptic
