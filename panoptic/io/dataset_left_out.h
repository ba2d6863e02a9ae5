// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Files that lie among the images of a recording and that no frame is made of.
#pragma once

#include <string>
#include <vector>

#include "panoptic/io/dataset_files.h"

namespace panoptic {

// A line for each folder and ending: "depth/: 20 files *.npy, the first is 00000.npy". In the folders of colour images, depth
// images and poses every file counts that is not hidden; in the recording's own folder images alone.
std::vector<std::string> files_left_out(const FileRecording& recording);

}  // namespace panoptic
