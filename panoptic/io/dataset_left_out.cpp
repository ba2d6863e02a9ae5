// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/dataset_left_out.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <string_view>

#include "panoptic/base/files.h"
#include "panoptic/io/image_names.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

using NamesByFolder = std::map<std::string, std::set<std::string>>;

bool is_image(const std::string& name) {
  constexpr std::array<std::string_view, 10> kEndings = {".png",  ".jpg", ".jpeg", ".pgm", ".ppm",
                                                         ".tiff", ".tif", ".npy",  ".exr", ".bmp"};
  return std::find(kEndings.begin(), kEndings.end(), ending_of(name)) != kEndings.end();
}

NamesByFolder used_files(const FileRecording& recording) {
  NamesByFolder used;
  for (const FileFrame& frame : recording.frames) {
    for (const std::string* file : {&frame.color, &frame.depth, &frame.pose_file, &frame.confidence}) {
      const fs::path path = fs::path(*file).lexically_normal();
      if (!file->empty()) used[path.parent_path().string()].insert(path.filename().string());
    }
  }
  return used;
}

}  // namespace

std::vector<std::string> files_left_out(const FileRecording& recording) {
  struct Kind {
    std::size_t count = 0;
    std::string first;
  };
  std::vector<std::string> lines;
  for (const auto& [folder, names] : used_files(recording)) {
    std::map<std::string, Kind> kinds;  // by ending
    for (const std::string& name : names_in_folder(recording.root / folder)) {
      const bool counts = !name.starts_with('.') && !names.contains(name) && (!folder.empty() || is_image(name)) &&
                          is_file(recording.root / folder / name);
      if (!counts) continue;
      Kind& kind = kinds[ending_of(name)];
      if (kind.count++ == 0) kind.first = name;
    }
    for (const auto& [ending, kind] : kinds) {
      lines.push_back(fmt::format("{}/: {} {}{}, the first is {}", folder.empty() ? "." : folder, kind.count,
                                  kind.count == 1 ? "file *" : "files *", ending, kind.first));
    }
  }
  return lines;
}

}  // namespace panoptic
