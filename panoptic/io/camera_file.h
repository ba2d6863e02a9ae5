// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Intrinsics in the files that lie beside images, under whichever of the usual names.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "panoptic/io/calibration.h"

namespace panoptic {

// The first of these names that the folder holds, in any case, as it is written there; where `counts` is given, of something that
// counts.
std::optional<std::string> first_named(const std::filesystem::path& folder, std::span<const std::string_view> names,
                                       const std::function<bool(const std::string& name)>& counts = {});

// The file with the intrinsics of a plain folder: K.txt, intrinsic.txt, camera_intrinsic.json, calibration.txt and their like.
std::optional<std::string> camera_file_in(const std::filesystem::path& folder);

// Reads such a file over the depth camera: a text file as read_camera_matrix does, or JSON with a matrix (of Open3D, of OpenCV)
// or with fx, fy, cx, cy, and with the images' size and the depth scale where it has them. Throws Error naming the file.
void read_camera_file(const std::filesystem::path& path, Calibration& calibration);

}  // namespace panoptic
