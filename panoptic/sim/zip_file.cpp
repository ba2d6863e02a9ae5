// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/zip_file.h"

#include <fmt/format.h>
#include <zip.h>

#include <memory>
#include <utility>

#include "panoptic/error.h"

namespace panoptic {
namespace {

struct CloseEntry {
  void operator()(zip_file_t* file) const { zip_fclose(file); }
};

std::string text_of(int code) {
  zip_error_t error;
  zip_error_init_with_code(&error, code);
  std::string text = zip_error_strerror(&error);
  zip_error_fini(&error);
  return text;
}

}  // namespace

ZipFile::ZipFile(std::filesystem::path path) : path_(std::move(path)) {
  int code = 0;
  archive_ = zip_open(path_.c_str(), ZIP_RDONLY, &code);
  if (archive_ == nullptr) throw Error(fmt::format("{}: cannot be read as a zip archive: {}", path_.string(), text_of(code)));
}

ZipFile::~ZipFile() { zip_discard(archive_); }

bool ZipFile::contains(const std::string& entry) const { return zip_name_locate(archive_, entry.c_str(), 0) >= 0; }

std::string ZipFile::read(const std::string& entry, std::size_t max_bytes) const {
  const auto fail = [&](const std::string& what) { throw Error(fmt::format("{}: entry {}: {}", path_.string(), entry, what)); };
  zip_stat_t stat;
  if (zip_stat(archive_, entry.c_str(), 0, &stat) != 0) fail("the archive has no such entry; install it again");
  if ((stat.valid & ZIP_STAT_SIZE) == 0 || stat.size > max_bytes)
    fail(fmt::format("{} bytes, more than the {} that are read here", stat.size, max_bytes));
  const std::unique_ptr<zip_file_t, CloseEntry> file(zip_fopen(archive_, entry.c_str(), 0));
  if (file == nullptr) fail(zip_strerror(archive_));
  std::string bytes(static_cast<std::size_t>(stat.size), '\0');
  std::size_t filled = 0;
  while (filled < bytes.size()) {
    const zip_int64_t count = zip_fread(file.get(), bytes.data() + filled, bytes.size() - filled);
    if (count <= 0) fail("damaged or cut off; install the archive again");
    filled += static_cast<std::size_t>(count);
  }
  char beyond = 0;  // reading past the end makes libzip compare the checksum
  if (zip_fread(file.get(), &beyond, 1) != 0) fail("damaged (its checksum or its size is wrong); install the archive again");
  return bytes;
}

}  // namespace panoptic
