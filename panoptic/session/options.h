// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Every option of the program in one aggregate; the defaults are here and nowhere else.
#pragma once

#include <filesystem>
#include <string>

#include "panoptic/base/config.h"
#include "panoptic/fusion/integrator.h"
#include "panoptic/fusion/label_tracker.h"
#include "panoptic/fusion/mesher.h"
#include "panoptic/fusion/object_maintenance.h"
#include "panoptic/fusion/registration.h"
#include "panoptic/fusion/regularizer.h"
#include "panoptic/map/voxel_map.h"
#include "panoptic/predict/predictor_networks.h"
#include "panoptic/session/online_options.h"

namespace panoptic {

struct Options {
  std::string labels;       // label set: a built-in name or a TOML file; empty = the predictions' own, else "indoor"
  std::string predictions;  // folder of predictions to use instead of networks; empty = none
  NetworkOptions networks;
  DepthOptions depth;
  MapOptions map;
  TrackerOptions tracker;
  IntegratorOptions integrator;
  MaintenanceOptions objects;
  RegularizerOptions regularizer;
  MesherOptions mesher;
  OnlineOptions online;
};
Fields fields(Options& options);

inline constexpr const char* kDefaultPreset = "default";

// The defaults with what the preset changes: kDefaultPreset changes nothing, "paper" follows the paper to the letter; the files
// in configs/presets. Throws Error naming the presets there are.
Options preset_options(const std::string& name);
std::string preset_names();  // those beside the default

// The defaults with what the TOML file changes. Throws Error.
Options load_options(const std::filesystem::path& path);

}  // namespace panoptic
