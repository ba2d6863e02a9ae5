// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Which pose of a list belongs to which frame.
#pragma once

#include <filesystem>

#include "panoptic/io/dataset_files.h"
#include "panoptic/io/pose_list.h"

namespace panoptic {

// Poses with names go to the images of that name; poses with numbers to the frames of that number, or, if that fits less, to
// those of that time in seconds, or in order where there are as many poses as colour images; poses without either in order. What
// was taken is said in `assumed`. `path` is where the list is from. Throws Error if the counts do not allow it or nothing fits.
void give_poses(FileRecording& recording, const PoseList& list, const std::filesystem::path& path);

}  // namespace panoptic
