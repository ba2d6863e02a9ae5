// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The furniture that homes are made of: textured models of Debian's package sweethome3d-furniture after a reviewed table
// (configs/sim/furniture.toml, compiled in), and parametric models for what the package lacks.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "panoptic/labels.h"
#include "panoptic/sim/scene.h"

namespace panoptic {

// One kind of thing that can stand in a home. `role` is what the placement rules go by: "double_bed", "nightstand",
// "dining_table", "dining_chair", "office_chair", "desk", "sofa", "wall_picture" ... (the table's head lists them all).
struct Furniture {
  std::string name;  // "Oak chair"
  std::string role;
  ClassId class_id = ClassId::kUnknown;
  Vec3f size_m = Vec3f::Zero();  // width (x), depth (y), height (z)
  float elevation_m = 0;         // of its bottom above the floor, or above the surface it stands on; pictures, upper cabinets
};

class Catalogue {
 public:
  // Reads the table and the package's list; models are loaded when asked for. Throws Error naming the Debian package if it is
  // absent, or the entry that is missing or damaged.
  explicit Catalogue(const std::filesystem::path& folder = "/usr/share/sweethome3d/furniture");
  // Reads another table in place of the built-in one: the text of a TOML file.
  Catalogue(const std::filesystem::path& folder, std::string_view table);
  ~Catalogue();
  Catalogue(const Catalogue&) = delete;
  Catalogue& operator=(const Catalogue&) = delete;

  // The furniture in the order of the table; the index is its name elsewhere.
  const std::vector<Furniture>& furniture() const;
  std::vector<std::size_t> with_role(std::string_view role) const;

  // Appends the model (scaled to size_m, in the frame that SceneModel states) with its materials and textures to the scene and
  // returns its index in scene.models. A model is read from its archive once in the life of the catalogue. Throws Error for a
  // damaged archive. One thread at a time.
  std::uint32_t add_model(std::size_t furniture, Scene& scene) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace panoptic
