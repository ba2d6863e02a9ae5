// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/zip_writer.h"

#include <fmt/format.h>
#include <zip.h>

#include <cstdlib>
#include <cstring>
#include <new>
#include <utility>

#include "panoptic/base/files.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const char* why) {
  throw Error(fmt::format("cannot write {}: {}; free space or choose another folder", path.string(), why));
}

}  // namespace

ZipWriter::ZipWriter(std::filesystem::path path) : path_(std::move(path)) {
  if (is_there(path_)) fail(path_, "it is there already");
  bytes_ = zip_source_buffer_create(nullptr, 0, 0, nullptr);
  if (bytes_ == nullptr) throw std::bad_alloc();
  archive_ = zip_open_from_source(bytes_, ZIP_CREATE | ZIP_TRUNCATE, nullptr);
  if (archive_ == nullptr) {
    zip_source_free(bytes_);
    throw std::bad_alloc();
  }
  zip_source_keep(bytes_);  // closing the archive gives up one of the two
}

ZipWriter::~ZipWriter() {
  if (archive_ != nullptr) zip_discard(archive_);
  zip_source_free(bytes_);
}

void ZipWriter::add(const std::string& entry, const std::vector<std::uint8_t>& bytes) {
  constexpr zip_uint16_t kFirstDay = 1U << 5U | 1U;  // 1 January 1980, where the format's time begins
  void* copy = std::malloc(bytes.size());            // NOLINT(cppcoreguidelines-no-malloc): libzip frees it
  if (copy == nullptr) throw std::bad_alloc();
  std::memcpy(copy, bytes.data(), bytes.size());
  constexpr int kLibraryFrees = 1;
  zip_source_t* source = zip_source_buffer(archive_, copy, bytes.size(), kLibraryFrees);
  if (source == nullptr) {
    std::free(copy);  // NOLINT(cppcoreguidelines-no-malloc)
    fail(path_, zip_strerror(archive_));
  }
  const zip_int64_t index = zip_file_add(archive_, entry.c_str(), source, ZIP_FL_ENC_UTF_8);
  if (index < 0) {
    zip_source_free(source);
    fail(path_, zip_strerror(archive_));
  }
  const auto position = static_cast<zip_uint64_t>(index);
  zip_set_file_compression(archive_, position, ZIP_CM_STORE, 0);
  zip_file_set_dostime(archive_, position, 0, kFirstDay, 0);
}

// libzip makes it in memory, so that all files come to the disk in one way.
void ZipWriter::finish() {
  if (zip_close(archive_) != 0) fail(path_, zip_strerror(archive_));
  archive_ = nullptr;
  zip_stat_t stat;
  if (zip_source_stat(bytes_, &stat) != 0 || zip_source_open(bytes_) != 0) fail(path_, "libzip lost it");
  std::string bytes(static_cast<std::size_t>(stat.size), '\0');
  const zip_int64_t count = zip_source_read(bytes_, bytes.data(), bytes.size());
  zip_source_close(bytes_);
  if (count < 0 || static_cast<std::size_t>(count) != bytes.size()) fail(path_, "libzip lost it");
  write_file(path_, bytes);
}

}  // namespace panoptic
