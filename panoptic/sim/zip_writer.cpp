// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/zip_writer.h"

#include <fmt/format.h>
#include <zip.h>

#include <cstdlib>
#include <cstring>
#include <new>
#include <utility>

#include "panoptic/base/error.h"

namespace panoptic {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const char* why) {
  throw Error(fmt::format("cannot write {}: {}; free space or choose another folder", path.string(), why));
}

}  // namespace

ZipWriter::ZipWriter(std::filesystem::path path) : path_(std::move(path)) {
  int code = 0;
  archive_ = zip_open(path_.c_str(), ZIP_CREATE | ZIP_EXCL, &code);
  if (archive_ != nullptr) return;
  zip_error_t error;
  zip_error_init_with_code(&error, code);
  const std::string why = zip_error_strerror(&error);
  zip_error_fini(&error);
  fail(path_, why.c_str());
}

ZipWriter::~ZipWriter() {
  if (archive_ != nullptr) zip_discard(archive_);
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

void ZipWriter::finish() {
  if (zip_close(archive_) != 0) fail(path_, zip_strerror(archive_));
  archive_ = nullptr;
}

}  // namespace panoptic
