// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/session/options.h"

namespace panoptic {

Fields fields(Options& o) {
  Fields all = {{"labels", &o.labels, "label set: a built-in name or a TOML file; empty: the predictions' own, else indoor", {}},
                {"predictions", &o.predictions, "folder of predictions to use instead of networks", {}}};
  append_group(all, "networks", fields(o.networks));
  append_group(all, "depth", fields(o.depth));
  append_group(all, "map", fields(o.map));
  append_group(all, "tracker", fields(o.tracker));
  append_group(all, "integrator", fields(o.integrator));
  append_group(all, "regularizer", fields(o.regularizer));
  append_group(all, "mesher", fields(o.mesher));
  return all;
}

Options load_options(const std::filesystem::path& path) {
  Options options;
  read_toml_file(path, fields(options));
  return options;
}

}  // namespace panoptic
