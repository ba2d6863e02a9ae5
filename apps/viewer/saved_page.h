// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The page with its map as a folder of files, which needs no server of ours.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/viewer/play_source.h"
#include "apps/viewer/result_folder.h"

namespace panoptic {

struct SavedPage {
  std::uint64_t bytes = 0;  // of all files
  std::size_t files = 0;
  std::size_t frames = 0;          // of the camera view
  std::vector<std::string> notes;  // a line each: what the page lacks, and why
};

// Writes index.html, assets/ and data/ into the folder, which must be absent or empty. The camera view gets at most `most_frames`
// of the recording's frames, evenly. Throws Error: the folder, a file that cannot be written, a program built without its page.
SavedPage save_page(const std::filesystem::path& folder, OpenedResult result, PlaySource play, std::size_t most_frames);

}  // namespace panoptic
