// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "bindings/python/bind.h"
#include "panoptic/map.h"
#include "panoptic/map_file.h"
#include "panoptic/mapper.h"
#include "panoptic/options.h"
#include "panoptic/query.h"

namespace panoptic::python {

// A map to read: one that was loaded, or that of a mapper.
struct MapView {
  std::shared_ptr<const void> owner;
  const PanopticMap& map;
  std::shared_ptr<Exclusive> use;
  Options options;
  std::vector<FrameRecord> frames = {};  // of the file
  bool is_fixed = false;                 // nobody changes it
  std::optional<MapQuery> query = {};    // of a fixed map, once somebody asked
  std::optional<Vec3d> noted_up = {};    // by the file
  const Mapper* mapper = nullptr;        // whose map it is
};

// Upwards in the world, as the cameras were mostly held; nothing if nobody knows.
inline std::optional<Vec3d> up_of(const MapView& view) { return view.mapper != nullptr ? view.mapper->up() : view.noted_up; }

// The space of a map that was seen to be empty.
struct FreeSpaceView {
  std::shared_ptr<MapView> map;
};

}  // namespace panoptic::python
