// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

namespace panoptic {
namespace {

[[noreturn]] void fail(std::string_view what, const std::filesystem::path& path, int error, std::string_view remedy) {
  throw FileError(fmt::format("{} {}: {}; {}", what, path.string(), os::reason(error), remedy));
}

// Absent is a status too; and what no file can be called is absent.
std::filesystem::file_status known(std::filesystem::file_status status, const std::filesystem::path& path,
                                   const std::error_code& error) {
  if (error == std::errc::filename_too_long) return std::filesystem::file_status(std::filesystem::file_type::not_found);
  if (!std::filesystem::status_known(status)) fail("cannot look at", path, error.value(), "check the path and the disk");
  return status;
}

std::filesystem::file_status status_of(const std::filesystem::path& path) {
  std::error_code error;
  return known(std::filesystem::status(path, error), path, error);
}

}  // namespace

std::string read_file(const std::filesystem::path& path, std::uintmax_t max_bytes) {
  const os::File file = os::open_to_read(path);
  const auto status = file.status();
  if (!status) fail("cannot read", path, errno, "check the path and its permissions");
  if (!status->is_regular) throw Error(fmt::format("cannot read {}: it is not a regular file", path.string()));
  if (status->size > max_bytes) {
    throw Error(fmt::format("refusing to read {}: {} bytes, more than the limit of {}", path.string(), status->size, max_bytes));
  }
  std::string bytes(status->size, '\0');
  const auto have = file.read(0, bytes.data(), bytes.size());
  if (!have) fail("cannot read", path, errno, "check the disk");
  bytes.resize(*have);
  return bytes;
}

std::filesystem::path partial_beside(const std::filesystem::path& path) {
  return path.parent_path() / fmt::format(".{}.{}.partial", path.filename().string(), os::process_id());
}

void write_file(const std::filesystem::path& path, std::string_view bytes) {
  PartialFile file(path);
  file.append(bytes);
  file.commit();
}

void write_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes) {
  write_file(path, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

PartialFile::PartialFile(std::filesystem::path path)
    : path_(std::move(path)), partial_(partial_beside(path_)), file_(os::open_to_write(partial_)) {
  if (!file_.is_open()) panoptic::fail("cannot write", path_, errno, "check that the folder exists and is writable");
}

PartialFile::~PartialFile() {
  if (file_.is_open()) os::remove(partial_);
}

void PartialFile::append(std::string_view bytes) {
  overwrite(size_, bytes);
  size_ += bytes.size();
}

void PartialFile::overwrite(std::uint64_t offset, std::string_view bytes) {
  if (!file_.write(offset, bytes)) fail(errno);
}

void PartialFile::commit() {
  if (!file_.sync()) fail(errno);
  if (file_.close() && os::rename(partial_, path_)) return;
  const int error = errno;
  os::remove(partial_);
  fail(error);
}

void PartialFile::fail(int error) const {
  panoptic::fail("cannot write", path_, error,
                 "free space or choose another output folder; an older file of that name is untouched");
}

void rename_file(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (!os::rename(from, to)) fail("cannot write", to, errno, "free space or choose another name");
}

bool rename_to_new(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (os::rename_to_new(from, to)) return true;
  if (errno == EEXIST) return false;
  fail("cannot write", to, errno, "free space or choose another name");
}

void require_writable_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder, error)) {
    throw FileError(fmt::format("cannot create the folder {}: {}; choose another output folder", folder.string(),
                                error ? error.message() : "a file of that name is in the way"));
  }
  const std::filesystem::path probe = folder / fmt::format(".probe.{}", os::process_id());
  const os::File file = os::open_to_write(probe);
  if (!file.is_open()) fail("cannot write into the folder", folder, errno, "choose another output folder");
  os::remove(probe);
}

bool is_there(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::exists(known(std::filesystem::symlink_status(path, error), path, error));
}
bool is_file(const std::filesystem::path& path) { return std::filesystem::is_regular_file(status_of(path)); }
bool is_folder(const std::filesystem::path& path) { return std::filesystem::is_directory(status_of(path)); }

std::vector<std::string> names_in_folder(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  if (!is_folder(folder)) return names;
  std::error_code error;
  do {
    names.clear();
    for (auto entry = std::filesystem::directory_iterator(folder, error);
         !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
      names.push_back(entry->path().filename().string());
    }
  } while (error == std::errc::interrupted);
  if (error) fail("cannot list the folder", folder, error.value(), "check the disk and the permissions");
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace panoptic
