// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The scenes of a batch: recordings that are mapped one by one, each into a folder of its own.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace panoptic {

struct BatchScene {
  std::string name;       // unique in its list, and good as the name of a folder: letters, digits, - . _
  std::string recording;  // absolute path, or "sim:..."
};

// Whether it is a simulated home, and no path.
bool is_simulated(const std::string& recording);

struct SceneList {
  std::vector<BatchScene> scenes;
  std::vector<std::string> left_out;  // names in the folder that are no scenes
};

// The recordings that a text file names, a line each (relative to its folder; empty lines and those that begin with # do not
// count), in its order; or the folders and .sens files in a folder, by name, but for `own` and what begins with a dot. A scene
// has the name of its recording; where several have one, the folders above are put in front, "chess_seq-01", until they differ.
// Throws Error for a recording that is not there, is named twice or cannot be told from another, a name that a batch needs
// itself, and for no scene at all.
SceneList read_scenes(const std::filesystem::path& list_or_folder, const std::vector<std::filesystem::path>& own = {});

}  // namespace panoptic
