// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "panoptic/error.h"

namespace panoptic {
namespace {

class Descriptor {
 public:
  Descriptor(const std::filesystem::path& path, int flags) : fd_(open_descriptor(path, flags)) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  int fd() const { return fd_; }
  bool open() const { return fd_ >= 0; }
  int release() { return std::exchange(fd_, -1); }
  // Interrupted or not, Linux has closed it.
  bool close() { return !open() || ::close(release()) == 0 || errno == EINTR; }

 private:
  int fd_;
};

[[noreturn]] void fail(std::string_view what, const std::filesystem::path& path, int error, std::string_view remedy) {
  throw FileError(fmt::format("{} {}: {}; {}", what, path.string(), std::strerror(error), remedy));
}

bool write_all(int fd, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

bool sync(int fd) {
  int result = 0;
  do {
    result = ::fsync(fd);
  } while (result != 0 && errno == EINTR);
  return result == 0;
}

std::filesystem::path temporary_beside(const std::filesystem::path& path) {
  return path.parent_path() / fmt::format(".{}.{}.partial", path.filename().string(), ::getpid());
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

int open_descriptor(const std::filesystem::path& path, int flags, unsigned mode) {
  int fd = -1;
  do {
    fd = ::open(path.c_str(), flags | O_CLOEXEC, mode);
  } while (fd < 0 && errno == EINTR);
  return fd;
}

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
  PartialFile file(path);
  file.append(bytes);
  file.commit();
}

void write_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes) {
  write_file(path, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

PartialFile::PartialFile(std::filesystem::path path) : path_(std::move(path)), partial_(temporary_beside(path_)) {
  Descriptor file(partial_, O_WRONLY | O_CREAT | O_TRUNC);
  if (!file.open()) panoptic::fail("cannot write", path_, errno, "check that the folder exists and is writable");
  fd_ = file.release();
}

PartialFile::~PartialFile() {
  if (fd_ < 0) return;
  ::close(fd_);
  ::unlink(partial_.c_str());
}

void PartialFile::append(std::string_view bytes) {
  if (!write_all(fd_, bytes)) fail(errno);
}

void PartialFile::overwrite(std::uint64_t offset, std::string_view bytes) {
  const off_t end = ::lseek(fd_, 0, SEEK_CUR);
  if (end < 0 || ::lseek(fd_, static_cast<off_t>(offset), SEEK_SET) < 0) fail(errno);
  if (!write_all(fd_, bytes) || ::lseek(fd_, end, SEEK_SET) < 0) fail(errno);
}

void PartialFile::commit() {
  if (!sync(fd_)) fail(errno);
  if (::close(std::exchange(fd_, -1)) == 0 || errno == EINTR) {
    if (::rename(partial_.c_str(), path_.c_str()) == 0) return;
  }
  const int error = errno;
  ::unlink(partial_.c_str());
  fail(error);
}

void PartialFile::fail(int error) const {
  panoptic::fail("cannot write", path_, error,
                 "free space or choose another output folder; an older file of that name is untouched");
}

void rename_file(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (::rename(from.c_str(), to.c_str()) != 0) fail("cannot write", to, errno, "free space or choose another name");
}

bool rename_to_new(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return true;
  if (errno == EINVAL || errno == ENOSYS) {  // a file system that cannot, like NFS, has links
    if (::link(from.c_str(), to.c_str()) == 0) {
      ::unlink(from.c_str());
      return true;
    }
  }
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
  const std::filesystem::path probe = folder / fmt::format(".probe.{}", ::getpid());
  const Descriptor file(probe, O_WRONLY | O_CREAT | O_TRUNC);
  if (!file.open()) fail("cannot write into the folder", folder, errno, "choose another output folder");
  ::unlink(probe.c_str());
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
