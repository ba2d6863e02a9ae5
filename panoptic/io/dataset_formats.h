// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// One function per folder format: nothing if the folder is not of this format, Error if it is but cannot be used. Folders
// are given absolute and without a trailing slash, since some formats keep a file in the folder above.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "panoptic/bag.h"
#include "panoptic/io/dataset_files.h"

namespace panoptic {

struct PairingOptions {
  std::optional<double> tolerance_s;  // how far apart the time stamps of a pair may be; nothing: what suits the format
  bool without_poses = false;         // poses are not looked for
};

std::optional<FileRecording> recognise_scannet_export(const std::filesystem::path& folder);      // the Python exporter's
std::optional<FileRecording> recognise_scannet_cpp_export(const std::filesystem::path& folder);  // also 3RScan, BundleFusion
std::optional<FileRecording> recognise_seven_scenes(const std::filesystem::path& folder);        // also 3DMatch
std::optional<FileRecording> recognise_tum(const std::filesystem::path& folder, const PairingOptions& pairing);  // also ICL-NUIM
std::optional<FileRecording> recognise_replica(const std::filesystem::path& folder);  // NICE-SLAM layout
std::optional<FileRecording> recognise_arkitscenes(const std::filesystem::path& folder, const PairingOptions& pairing);
std::optional<FileRecording> recognise_stray(const std::filesystem::path& folder, const PairingOptions& pairing);
std::optional<FileRecording> recognise_record3d(const std::filesystem::path& folder);
std::optional<FileRecording> recognise_rtabmap(const std::filesystem::path& folder, const PairingOptions& pairing);
std::optional<FileRecording> recognise_sun3d(const std::filesystem::path& folder, const PairingOptions& pairing);
// Also Open3D's recorder and Semantic-NeRF.
std::optional<FileRecording> recognise_plain_folder(const std::filesystem::path& folder, const PairingOptions& pairing);
std::optional<FileRecording> recognise_flat_folder(const std::filesystem::path& folder, const PairingOptions& pairing);

// open_bag, also for a camera that is to be tracked. Throws NoPoses if all is there but poses.
std::unique_ptr<Dataset> open_bag_as(const std::filesystem::path& path, const BagChoice& choice,
                                     const std::filesystem::path& calibration, const PairingOptions& pairing);

// The list of poses of a plain or flat folder, under one of its usual names, relative to the folder.
std::optional<std::string> pose_file_in(const std::filesystem::path& folder);

// The format that a folder (or a file) of no known one is nearest to and what it lacks, in a few words; nothing if it is like
// none.
std::string why_no_recording(const std::filesystem::path& folder);

// Whether a folder holds poses in a form that is not read.
bool has_unread_poses(const std::filesystem::path& folder);

}  // namespace panoptic
