// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The options of the runs of a batch: the words after --.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/panoptic/arguments.h"
#include "panoptic/batch/scene_list.h"

namespace panoptic {

using Words = std::vector<std::string>;

// The run options of a scene: {} is its recording, {name} its name.
Words options_for(const BatchScene& scene, const Words& run_options);

// The words without an option and its values, however it was written.
Words without(const Words& words, const std::string& option);

// Throws UsageError for an option that batch gives each run itself, or that needs somebody to look on.
void require_allowed(const Words& run_options);

// Throws UsageError for one folder of predictions, or file of corrections, that would be that of several scenes.
void require_own_inputs(const Words& run_options, std::size_t scenes);

// Parses the options as `panoptic run` will. Throws UsageError.
Arguments run_arguments(const BatchScene& scene, const std::filesystem::path& folder, const Words& options);

}  // namespace panoptic
