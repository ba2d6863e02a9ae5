// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/parametric.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "panoptic/error.h"
#include "panoptic/sim/parametric_shapes.h"

namespace panoptic {
namespace {

using Make = void (*)(const ParametricShape&, ModelBuilder&);

const std::map<std::string, Make, std::less<>>& makers() {
  static const std::map<std::string, Make, std::less<>> kMakers = {{"basin", make_basin},
                                                                   {"bathtub", make_bathtub},
                                                                   {"bin", make_bin},
                                                                   {"bookshelf", make_bookshelf},
                                                                   {"counter", make_counter},
                                                                   {"curtain", make_curtain},
                                                                   {"door", make_door},
                                                                   {"floor_lamp", make_floor_lamp},
                                                                   {"monitor", make_monitor},
                                                                   {"picture", make_picture},
                                                                   {"radiator", make_radiator},
                                                                   {"refrigerator", make_refrigerator},
                                                                   {"shower_curtain", make_curtain},
                                                                   {"sideboard", make_sideboard},
                                                                   {"stove", make_stove},
                                                                   {"window", make_window}};
  return kMakers;
}

}  // namespace

std::vector<std::string> parametric_shapes() {
  std::vector<std::string> names;
  for (const auto& [name, make] : makers()) names.push_back(name);
  return names;
}

void require_parametric_shape(std::string_view shape) {
  if (!makers().contains(shape))
    throw Error(fmt::format("there is no parametric shape '{}': name one of {}", shape, fmt::join(parametric_shapes(), ", ")));
}

ModelAsset make_parametric(const ParametricShape& shape) {
  require_parametric_shape(shape.shape);
  ModelBuilder builder;
  makers().find(shape.shape)->second(shape, builder);
  ModelAsset asset = builder.take();
  asset.model.name = shape.shape;
  fit_to_size(asset.model, 0, shape.size_m);
  return asset;
}

}  // namespace panoptic
