// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Shared by the targets: taking an input apart, files to put it into, and telling a refusal from a fault.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "fuzz/targets.h"
#include "panoptic/error.h"

namespace panoptic::fuzz {

inline std::string_view text_of(Input input) { return {reinterpret_cast<const char*>(input.data()), input.size()}; }
inline Input bytes_of(std::string_view text) { return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}; }

// Between the files of an input that is several. Readable, and short enough for a fuzzer to copy whole.
inline constexpr std::string_view kSeparator = "\n%%%%\n";

// At least one and at most `most` parts; the last one keeps further separators.
std::vector<Input> parts_of(Input input, std::size_t most);

// Ends the process, saying so, unless the condition holds.
void require(bool condition, const char* what);

// A folder of this process, removed at its end. Below the folder for temporary files: give one in memory.
class Scratch {
 public:
  explicit Scratch(std::string_view name);
  ~Scratch();
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  const std::filesystem::path& path() const { return path_; }
  // Makes the file in a folder that exists, or replaces it, and returns its path.
  std::filesystem::path put(std::string_view name, Input bytes) const;

 private:
  std::filesystem::path path_;
};

// Did the action end well? False if it threw an Error as it should be: something to say, on one line.
template <typename Action>
bool succeeds(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    const std::string_view message = error.what();
    require(!message.empty() && message.find('\n') == std::string_view::npos, "an error is one line");
    return false;
  }
  return true;
}

}  // namespace panoptic::fuzz
