// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Recordings whose camera is to be tracked: they need no poses.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "panoptic/error.h"
#include "panoptic/source.h"

namespace panoptic {

// Thrown by open_recording: all is there but poses.
class NoPoses : public Error {
 public:
  using Error::Error;
};

// The same as open_recording, but the pose of every frame is the identity, whatever the recording says. Throws Error also for a
// list of recordings, which is tracked one by one.
std::unique_ptr<Dataset> open_without_poses(const std::filesystem::path& path, const std::filesystem::path& calibration = {},
                                            std::optional<double> pair_tolerance_s = {});

}  // namespace panoptic
