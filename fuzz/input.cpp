// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "fuzz/input.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

namespace panoptic::fuzz {

std::vector<Input> parts_of(Input input, std::size_t most) {
  std::vector<Input> parts;
  while (parts.size() + 1 < most) {
    const std::size_t end = text_of(input).find(kSeparator);
    if (end == std::string_view::npos) break;
    parts.push_back(input.first(end));
    input = input.subspan(end + kSeparator.size());
  }
  parts.push_back(input);
  return parts;
}

void require(bool condition, const char* what) {
  if (condition) return;
  std::fprintf(stderr, "not as it must be: %s\n", what);
  std::abort();
}

Scratch::Scratch(std::string_view name)
    : path_(std::filesystem::temp_directory_path() / fmt::format("panoptic_fuzz_{}_{}", ::getpid(), name)) {
  std::filesystem::create_directories(path_);
}

Scratch::~Scratch() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::filesystem::path Scratch::put(std::string_view name, Input bytes) const {
  std::filesystem::path file = path_ / name;
  const int fd = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  require(fd >= 0 && ::write(fd, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()), "files can be written");
  ::close(fd);
  return file;
}

}  // namespace panoptic::fuzz
