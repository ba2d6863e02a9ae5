// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The seam to the operating system. A call that a signal interrupts is made again. What fails returns false, or nothing, and
// leaves the reason in errno: the caller knows what to say of it.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

namespace panoptic::os {

// Two paths with the same FileId lead to the same file.
struct FileId {
  std::uint64_t device = 0;
  std::uint64_t number = 0;

  auto operator<=>(const FileId&) const = default;
};

struct FileStatus {
  FileId id;
  bool is_regular = false;
  std::uint64_t size = 0;
};

// An open file, or none. It is closed when its owner goes, and when the process starts another program. Threads may read at once.
class File {
 public:
  File() = default;
  explicit File(int descriptor) : descriptor_(descriptor) {}  // which it owns from now on; below 0: none
  ~File() { close(); }
  File(File&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  File& operator=(File&& other) noexcept;
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  bool is_open() const { return descriptor_ >= 0; }
  bool close();  // false: what was written may be lost

  std::optional<FileStatus> status() const;  // of none: nothing, and errno as it is
  std::optional<std::size_t> read(std::uint64_t offset, void* to, std::size_t bytes) const;  // fewer where the file ends
  bool write(std::uint64_t offset, std::string_view bytes) const;
  bool sync() const;
  bool lock() const;  // against other processes and other open Files, without waiting: EWOULDBLOCK if somebody has it
  bool take_space(std::uint64_t offset, std::uint64_t bytes) const;  // on the disk, so that it cannot be full later
  // Maps it into memory, to read and to write, at a multiple of `alignment`; nullptr if it fails. Pages come in one by one, when
  // they are needed.
  void* map(std::uint64_t offset, std::size_t bytes, std::size_t alignment) const;

 private:
  int descriptor_ = -1;
};

File open_to_read(const std::filesystem::path& path);         // a pipe without a writer does not make it wait
File open_to_write(const std::filesystem::path& path);        // new, or emptied
File open_without_name(const std::filesystem::path& folder);  // new; vanishes with the File, however the process ends

std::optional<FileStatus> status_of(const std::filesystem::path& path);
bool rename(const std::filesystem::path& from, const std::filesystem::path& to);
bool rename_to_new(const std::filesystem::path& from, const std::filesystem::path& to);  // EEXIST if the name is taken
void remove(const std::filesystem::path& path);

void unmap(void* memory, std::size_t bytes);
void give_back(void* memory, std::size_t bytes);  // the memory of what is mapped there; its contents are in the file

std::string reason(int error);  // of an errno, in words
int process_id();
std::string host_name();  // empty if there is none
bool is_terminal(std::FILE* stream);
std::string environment(const char* name);                 // of the process; empty if it is not set
void name_thread(std::jthread& thread, const char* name);  // for top and debuggers; at most 15 letters
bool call_in_children(void (*function)());                 // first thing after a fork, in the child

}  // namespace panoptic::os
