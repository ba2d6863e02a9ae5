// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapfile/map_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <mutex>
#include <set>

#include "panoptic/base/files.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

using FileId = std::pair<dev_t, ino_t>;

// The files that this process writes. None of them may be opened here once more, see the header.
struct OwnFiles {
  std::mutex mutex;
  std::set<FileId> ids;
};

OwnFiles& own_files() {
  static OwnFiles files;
  return files;
}

bool take(FileId id) {
  OwnFiles& own = own_files();
  const std::lock_guard guard(own.mutex);
  return own.ids.insert(id).second;
}

void give_back(FileId id) {
  OwnFiles& own = own_files();
  const std::lock_guard guard(own.mutex);
  own.ids.erase(id);
}

[[noreturn]] void refuse(const std::filesystem::path& path) {
  throw Error(fmt::format("another run writes {}: wait until it is done, or choose another file", path.string()));
}

[[noreturn]] void fail(const std::filesystem::path& path, int error) {
  throw FileError(fmt::format("cannot open {}: {}; check the path and its permissions", path.string(), std::strerror(error)));
}

FileId id_of(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) fail(path, errno);
  return {status.st_dev, status.st_ino};
}

FileId id_of(int fd, const std::filesystem::path& path) {
  struct stat status {};
  if (::fstat(fd, &status) != 0) fail(path, errno);
  return {status.st_dev, status.st_ino};
}

// A descriptor of a file with an advisory lock on it, closed unless it is released.
class LockedFile {
 public:
  explicit LockedFile(const std::filesystem::path& path)
      : fd_(open_descriptor(path, O_RDONLY | O_NONBLOCK)) {  // a pipe without a writer must not hang us
    if (fd_ < 0) fail(path, errno);
    int result = 0;
    do {
      result = ::flock(fd_, LOCK_EX | LOCK_NB);
    } while (result != 0 && errno == EINTR);
    if (result == 0) return;
    const int error = errno;
    ::close(fd_);
    if (error == EWOULDBLOCK) refuse(path);
    fail(path, error);
  }
  ~LockedFile() {
    if (fd_ >= 0) ::close(fd_);
  }
  LockedFile(const LockedFile&) = delete;
  LockedFile& operator=(const LockedFile&) = delete;

  int fd() const { return fd_; }
  int release() { return std::exchange(fd_, -1); }

 private:
  int fd_;
};

}  // namespace

MapLock::MapLock(const std::filesystem::path& path) {
  // Between two looks at the path another process may have put another file there. Once the lock is on the file of that name
  // nobody does: whoever replaces a map holds the lock on the old one.
  for (;;) {
    file_ = id_of(path);
    if (!take(file_)) refuse(path);
    try {
      LockedFile file(path);
      if (id_of(file.fd(), path) == file_ && id_of(path) == file_) {
        fd_ = file.release();
        return;
      }
    } catch (...) {
      give_back(file_);
      throw;
    }
    give_back(file_);
  }
}

MapLock::~MapLock() {
  if (fd_ < 0) return;
  ::close(fd_);
  give_back(file_);
}

}  // namespace panoptic
