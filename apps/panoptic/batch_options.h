// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The options of the runs of a batch: the words after --.
#pragma once

#include <filesystem>
#include <map>
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

// The use that is made of a file of the world or a folder, by its path.
using InputOwners = std::map<std::filesystem::path, std::string>;

// Throws UsageError if the folder of predictions, or file of corrections, is already that of another scene; empty: there is none.
void require_own_input(const std::string& what, const std::string& path, const BatchScene& scene, InputOwners& owners);

// Throws Error if what the batch makes would lie in a recording, or a recording in what it makes, also through links.
void require_apart(const Arguments& arguments, const std::vector<BatchScene>& scenes);

// Throws UsageError for networks in --set, which would stand against the shared predictions that are made of them.
void require_flags_for_networks(const Words& settings);

// Parses the options as `panoptic run` will. Throws UsageError.
Arguments run_arguments(const BatchScene& scene, const std::filesystem::path& folder, const Words& options);

}  // namespace panoptic
