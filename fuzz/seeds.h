// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Inputs to start from, as files: FOLDER/<target>/<name>.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fuzz/input.h"
#include "panoptic/base/files.h"

namespace panoptic::fuzz {

class Seeds {
 public:
  explicit Seeds(std::filesystem::path root) : root_(std::move(root)) {}

  void put(const char* target, const std::string& name, std::string_view bytes) {
    std::filesystem::create_directories(root_ / target);
    write_file(root_ / target / name, bytes);
    ++count_;
  }
  // Several files as one input, after the byte that says what they are.
  void put(const char* target, const std::string& name, const std::vector<std::string>& parts, int kind = -1) {
    std::string bytes = kind < 0 ? "" : std::string(1, static_cast<char>(kind));
    for (std::size_t i = 0; i < parts.size(); ++i) bytes += (i == 0 ? "" : std::string(kSeparator)) + parts[i];
    put(target, name, bytes);
  }
  std::size_t count() const { return count_; }

 private:
  std::filesystem::path root_;
  std::size_t count_ = 0;
};

// The texts of recordings in folders.
void recording_seeds(Seeds& seeds);

}  // namespace panoptic::fuzz
