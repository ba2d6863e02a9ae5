// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace panoptic {

struct RegularizedFile {
  std::size_t changed = 0;  // blocks with other labels
  std::size_t blocks = 0;
  std::size_t objects = 0;
  std::string note;  // what the file lacked because its format is older; else empty
};

// Regularizes the labels of a map file in place, all of them and from what the frames voted for. `settings`: options that differ
// from those of its run, "key=value". A file of an older format is saved anew in today's. The file is whole at any moment.
// Throws Error: no sound map, another process writes it, or a wrong setting.
RegularizedFile regularize_map_file(const std::filesystem::path& path, const std::vector<std::string>& settings = {});

}  // namespace panoptic
