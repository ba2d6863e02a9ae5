// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapfile/map_lock.h"

#include <fmt/format.h>

#include <cerrno>
#include <mutex>
#include <optional>
#include <set>
#include <utility>

#include "panoptic/base/files.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

// The files that this process writes. None of them may be opened here once more, see the header.
struct OwnFiles {
  std::mutex mutex;
  std::set<os::FileId> ids;
};

OwnFiles& own_files() {
  static OwnFiles files;
  return files;
}

bool take(os::FileId id) {
  OwnFiles& own = own_files();
  const std::lock_guard guard(own.mutex);
  return own.ids.insert(id).second;
}

void give_back(os::FileId id) {
  OwnFiles& own = own_files();
  const std::lock_guard guard(own.mutex);
  own.ids.erase(id);
}

[[noreturn]] void refuse(const std::filesystem::path& path) {
  throw Error(fmt::format("another run writes {}: wait until it is done, or choose another file", path.string()));
}

[[noreturn]] void fail(const std::filesystem::path& path, int error) {
  throw FileError(fmt::format("cannot open {}: {}; check the path and its permissions", path.string(), os::reason(error)));
}

os::FileId id_in(const std::optional<os::FileStatus>& status, const std::filesystem::path& path) {
  if (!status) fail(path, errno);
  return status->id;
}

}  // namespace

MapLock::MapLock(const std::filesystem::path& path) {
  // Between two looks at the path another process may have put another file there. Once the lock is on the file of that name
  // nobody does: whoever replaces a map holds the lock on the old one.
  for (;;) {
    id_ = id_in(os::status_of(path), path);
    if (!take(id_)) refuse(path);
    try {
      os::File file = os::open_to_read(path);
      const os::FileId opened = id_in(file.status(), path);
      if (!file.lock()) {
        errno == EWOULDBLOCK ? refuse(path) : fail(path, errno);
      }
      if (opened == id_ && id_in(os::status_of(path), path) == id_) {
        file_ = std::move(file);
        return;
      }
    } catch (...) {
      give_back(id_);
      throw;
    }
    give_back(id_);
  }
}

MapLock::~MapLock() {
  if (!file_.is_open()) return;
  file_.close();
  give_back(id_);
}

}  // namespace panoptic
