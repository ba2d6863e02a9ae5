// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/options.h"

#include <fmt/format.h>

#include "panoptic/base/config.h"
#include "panoptic/crf/regularizer.h"
#include "panoptic/error.h"
#include "panoptic/fusion/integrator.h"
#include "panoptic/fusion/label_tracker.h"
#include "panoptic/fusion/motion_mask.h"
#include "panoptic/fusion/registration.h"
#include "panoptic/fusion/space_observer.h"
#include "panoptic/map/option_fields.h"
#include "panoptic/mapping/builtin_presets.h"
#include "panoptic/mapping/option_fields.h"
#include "panoptic/meshing/mesher.h"
#include "panoptic/objects/object_maintenance.h"
#include "panoptic/predict/option_fields.h"
#include "panoptic/run_outputs.h"

namespace panoptic {

Fields fields(Options& o) {
  Fields all = {{"labels", &o.labels, "label set: a built-in name or a TOML file; empty: the predictions' own, else indoor", {}},
                {"predictions", &o.predictions, "folder of predictions to use instead of networks", {}}};
  append_group(all, "networks", fields(o.networks));
  append_group(all, "depth", fields(o.depth));
  append_group(all, "map", fields(o.map));
  append_group(all, "tracker", fields(o.tracker));
  append_group(all, "integrator", fields(o.integrator));
  append_group(all, "carving", fields(o.carving));
  append_group(all, "moving", fields(o.moving));
  append_group(all, "objects", fields(o.objects));
  append_group(all, "regularizer", fields(o.regularizer));
  append_group(all, "mesher", fields(o.mesher));
  append_group(all, "online", fields(o.online));
  return all;
}

const Options& checked(const Options& options) {
  Options copy = options;
  const Fields all = fields(copy);
  read_toml_text(to_toml(all), "options", all);  // the reader looks at every range
  if (options.depth.min_m >= options.depth.max_m) {
    throw Error("depth.min_m is not below depth.max_m: no reading would be left; swap or correct them");
  }
  const auto require_free_space = [&](bool is_on, const char* name) {
    if (is_on && !options.map.free_space) {
      throw Error(fmt::format("{0} needs map.free_space, which is off; set {0} to false as well", name));
    }
  };
  require_free_space(options.carving.enabled, "carving.enabled");
  require_free_space(options.moving.points, "moving.points");
  require_free_space(options.moving.objects, "moving.objects");
  return options;
}

Options preset_options(const std::string& name) {
  Options options;
  if (name == kDefaultPreset) return options;
  const auto text = builtin_preset(name);
  if (!text) throw Error(fmt::format("there is no preset '{}': use {} or {}", name, kDefaultPreset, builtin_preset_names()));
  read_toml_text(*text, fmt::format("preset {}", name), fields(options));
  return options;
}

std::string preset_names() { return builtin_preset_names(); }

Options load_options(const std::filesystem::path& path) {
  Options options;
  read_toml_file(path, fields(options));
  return options;
}

void set_option(Options& options, const std::string& assignment) { set_field(fields(options), assignment); }

std::string to_toml(const Options& options) {
  Options copy = options;
  return to_toml(fields(copy));
}

}  // namespace panoptic
