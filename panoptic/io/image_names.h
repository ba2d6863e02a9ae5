// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Which images belong together and in which order they come, told by their names. All numbers in a name count, in the order in
// which they stand; those that are the same in all names (a camera's, a date's) say nothing and are left out.
#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "panoptic/io/dataset_files.h"

namespace panoptic {

// The usual names of the folders, in small letters.
inline constexpr std::array<std::string_view, 7> kColorFolders = {"images", "color", "rgb", "image", "colour", "imgs", "img"};
inline constexpr std::array<std::string_view, 6> kDepthFolders = {"depth",       "depths",     "depth_images",
                                                                  "depth_image", "depth_maps", "depth_map"};

inline constexpr std::array<std::string_view, 3> kColorEndings = {".png", ".jpg", ".jpeg"};
inline constexpr std::array<std::string_view, 6> kDepthEndings = {".png", ".pgm", ".tif", ".tiff", ".npy", ".exr"};
inline constexpr std::array<std::string_view, 1> kPoseEndings = {".txt"};

// The ending of a file name in small letters: ".jpg".
std::string ending_of(const std::filesystem::path& path);

// The files of a folder with one of these endings, in any case, as paths relative to the recording, sorted. Hidden files are
// none.
std::vector<std::string> files_in(const std::filesystem::path& root, const std::string& folder,
                                  std::span<const std::string_view> endings);

// Throws Error if `files`, what files_in found in a folder of colour images, is empty: then what is there has another ending.
void require_color_images(const std::filesystem::path& root, const std::string& folder, const std::vector<std::string>& files);

// Paths relative to the recording; a file of the pose belongs to the images whose numbers it has.
struct RecordingFiles {
  std::vector<std::string> color;
  std::vector<std::string> depth;
  std::vector<std::string> poses;
};

// Fills in the frames: one position for every place in the sequence that a colour or a depth image has, in natural order. Equally
// many colour and depth images whose numbers differ throughout are paired in order, and `assumed` says so. Where some of the
// files of one kind have another form of name ("0001_vis.png" beside "0001.png"), those of the form that the others have count.
// Throws Error, beginning with the recording's folder, if no image has a partner or two have the same place.
void add_frames_by_name(FileRecording& recording, const RecordingFiles& files);

}  // namespace panoptic
