// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/os.h"

#include <fcntl.h>
#include <pthread.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <system_error>

#include "panoptic/base/memory.h"
#include "panoptic/profile.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace panoptic {
namespace os {
namespace {

template <typename Call>
auto again_if_interrupted(const Call& call) {
  auto result = call();
  while (result < 0 && errno == EINTR) result = call();
  return result;
}

int open_descriptor(const std::filesystem::path& path, int flags, mode_t mode = 0666) {
  return again_if_interrupted([&] { return ::open(path.c_str(), flags | O_CLOEXEC, mode); });
}

FileStatus to_status(const struct stat& status) {
  return {{status.st_dev, status.st_ino}, S_ISREG(status.st_mode), static_cast<std::uint64_t>(status.st_size)};
}

// Addresses where nothing lies yet; nullptr if there are none.
void* aligned_place(std::size_t bytes, std::size_t alignment) {
  void* const memory = ::mmap(nullptr, bytes + alignment, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) return nullptr;
  const std::size_t before = (alignment - reinterpret_cast<std::uintptr_t>(memory) % alignment) % alignment;
  std::byte* const place = static_cast<std::byte*>(memory) + before;
  if (before > 0) ::munmap(memory, before);
  ::munmap(place + bytes, alignment - before);
  return place;
}

}  // namespace

File& File::operator=(File&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

bool File::close() {
  if (!is_open()) return true;
  return ::close(std::exchange(descriptor_, -1)) == 0 || errno == EINTR;  // interrupted or not, Linux has closed it
}

std::optional<FileStatus> File::status() const {
  struct stat status {};
  if (!is_open() || ::fstat(descriptor_, &status) != 0) return std::nullopt;
  return to_status(status);
}

std::optional<std::size_t> File::read(std::uint64_t offset, void* to, std::size_t bytes) const {
  std::size_t have = 0;
  while (have < bytes) {
    const ssize_t got = again_if_interrupted(
        [&] { return ::pread(descriptor_, static_cast<char*>(to) + have, bytes - have, static_cast<off_t>(offset + have)); });
    if (got < 0) return std::nullopt;
    if (got == 0) break;
    have += static_cast<std::size_t>(got);
  }
  return have;
}

bool File::write(std::uint64_t offset, std::string_view bytes) const {
  while (!bytes.empty()) {
    const ssize_t written =
        again_if_interrupted([&] { return ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset)); });
    if (written < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
    offset += static_cast<std::uint64_t>(written);
  }
  return true;
}

bool File::sync() const {
  return again_if_interrupted([&] { return ::fsync(descriptor_); }) == 0;
}

bool File::lock() const {
  return again_if_interrupted([&] { return ::flock(descriptor_, LOCK_EX | LOCK_NB); }) == 0;
}

bool File::take_space(std::uint64_t offset, std::uint64_t bytes) const {
  do {
    errno = ::posix_fallocate(descriptor_, static_cast<off_t>(offset), static_cast<off_t>(bytes));
  } while (errno == EINTR);
  return errno == 0;
}

void* File::map(std::uint64_t offset, std::size_t bytes, std::size_t alignment) const {
  void* const place = aligned_place(bytes, alignment);
  if (place == nullptr) return nullptr;
  const int flags = MAP_SHARED | MAP_FIXED;
  if (::mmap(place, bytes, PROT_READ | PROT_WRITE, flags, descriptor_, static_cast<off_t>(offset)) == MAP_FAILED) return nullptr;
  ::madvise(place, bytes, MADV_RANDOM);
  return place;
}

File open_to_read(const std::filesystem::path& path) { return File(open_descriptor(path, O_RDONLY | O_NONBLOCK)); }

File open_to_write(const std::filesystem::path& path) { return File(open_descriptor(path, O_WRONLY | O_CREAT | O_TRUNC)); }

// Not every file system has files without a name; then one whose name is removed at once.
File open_without_name(const std::filesystem::path& folder) {
  File file(open_descriptor(folder, O_TMPFILE | O_RDWR, 0600));
  if (file.is_open()) return file;
  std::string name = (folder / "panoptic_XXXXXX").string();
  File named(::mkostemp(name.data(), O_CLOEXEC));
  if (named.is_open()) ::unlink(name.c_str());
  return named;
}

std::optional<FileStatus> status_of(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return std::nullopt;
  return to_status(status);
}

bool rename(const std::filesystem::path& from, const std::filesystem::path& to) {
  return ::rename(from.c_str(), to.c_str()) == 0;
}

bool rename_to_new(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return true;
  const bool has_links_alone = errno == EINVAL || errno == ENOSYS;  // a file system like NFS
  if (!has_links_alone || ::link(from.c_str(), to.c_str()) != 0) return false;
  ::unlink(from.c_str());
  return true;
}

void remove(const std::filesystem::path& path) { ::unlink(path.c_str()); }

void unmap(void* memory, std::size_t bytes) { ::munmap(memory, bytes); }

void give_back(void* memory, std::size_t bytes) { ::madvise(memory, bytes, MADV_DONTNEED); }

std::string reason(int error) { return std::generic_category().message(error); }

int process_id() { return ::getpid(); }

std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

bool is_terminal(std::FILE* stream) { return ::isatty(::fileno(stream)) == 1; }

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

void name_thread(std::jthread& thread, const char* name) { ::pthread_setname_np(thread.native_handle(), name); }

bool call_in_children(void (*function)()) { return ::pthread_atfork(nullptr, nullptr, function) == 0; }

}  // namespace os

double peak_rss_mb() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1024 / 1e6;
}

double rss_mb() { return static_cast<double>(resident_bytes()) / 1e6; }

std::size_t resident_bytes() {
  std::size_t all_pages = 0;
  std::size_t resident_pages = 0;
  std::ifstream("/proc/self/statm") >> all_pages >> resident_pages;
  return resident_pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

void give_back_free_memory() {
#ifdef __GLIBC__
  ::malloc_trim(0);
#endif
}

}  // namespace panoptic
