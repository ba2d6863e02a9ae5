// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The input of a result, as a number: where it is the same, the result need not be made again.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "panoptic/base/compression.h"

namespace panoptic {

class Fingerprint {
 public:
  void add(std::string_view text);  // "ab", "c" is another one than "a", "bc"
  // Path, size and time of the last change of the file, or of all files in the folder and below, which are not read. One that is
  // not there counts as such. Throws FileError.
  void add_stamps(const std::filesystem::path& path);
  // The bytes of the running program: another version is another one.
  void add_this_program();

  std::string text() const;  // 16 hexadecimal digits

 private:
  std::uint64_t hash_ = kEmptyChecksum;
};

// A recording as a batch takes it: "sim:..." by its name, a list of recordings with all that it names, else its files.
void add_recording(Fingerprint& fingerprint, const std::string& recording);

}  // namespace panoptic
