// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "panoptic/base/error.h"

namespace panoptic {
namespace {

class Descriptor {
 public:
  Descriptor(const std::filesystem::path& path, int flags) : fd_(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  int fd() const { return fd_; }
  bool open() const { return fd_ >= 0; }
  int close() { return open() ? ::close(std::exchange(fd_, -1)) : 0; }

 private:
  int fd_;
};

[[noreturn]] void fail(std::string_view what, const std::filesystem::path& path, int error, std::string_view remedy) {
  throw Error(fmt::format("{} {}: {}; {}", what, path.string(), std::strerror(error), remedy));
}

bool write_all(int fd, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

std::filesystem::path temporary_beside(const std::filesystem::path& path) {
  return path.parent_path() / fmt::format(".{}.{}.partial", path.filename().string(), ::getpid());
}

}  // namespace

std::string read_file(const std::filesystem::path& path, std::uintmax_t max_bytes) {
  const Descriptor file(path, O_RDONLY | O_NONBLOCK);  // a pipe without a writer must not hang us
  if (!file.open()) fail("cannot read", path, errno, "check the path and its permissions");
  struct stat status {};
  if (::fstat(file.fd(), &status) != 0) fail("cannot read", path, errno, "check the path and its permissions");
  if (!S_ISREG(status.st_mode)) throw Error(fmt::format("cannot read {}: it is not a regular file", path.string()));
  const auto size = static_cast<std::uintmax_t>(status.st_size);
  if (size > max_bytes) {
    throw Error(fmt::format("refusing to read {}: {} bytes, more than the limit of {}", path.string(), size, max_bytes));
  }
  std::string bytes(size, '\0');
  std::size_t have = 0;
  while (have < bytes.size()) {
    const ssize_t got = ::read(file.fd(), bytes.data() + have, bytes.size() - have);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail("cannot read", path, errno, "check the disk");
    if (got == 0) break;
    have += static_cast<std::size_t>(got);
  }
  bytes.resize(have);
  return bytes;
}

void write_file(const std::filesystem::path& path, std::string_view bytes) {
  const std::filesystem::path partial = temporary_beside(path);
  Descriptor file(partial, O_WRONLY | O_CREAT | O_TRUNC);
  if (!file.open()) fail("cannot write", path, errno, "check that the folder exists and is writable");
  const bool written = write_all(file.fd(), bytes) && ::fsync(file.fd()) == 0 && file.close() == 0;
  if (!written || ::rename(partial.c_str(), path.c_str()) != 0) {
    const int error = errno;
    ::unlink(partial.c_str());
    fail("cannot write", path, error, "free space or choose another output folder; an older file of that name is untouched");
  }
}

void write_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes) {
  write_file(path, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

void require_writable_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder, error)) {
    throw Error(fmt::format("cannot create the folder {}: {}; choose another output folder", folder.string(),
                            error ? error.message() : "a file of that name is in the way"));
  }
  const std::filesystem::path probe = folder / fmt::format(".probe.{}", ::getpid());
  const Descriptor file(probe, O_WRONLY | O_CREAT | O_TRUNC);
  if (!file.open()) fail("cannot write into the folder", folder, errno, "choose another output folder");
  ::unlink(probe.c_str());
}

}  // namespace panoptic
