// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The .sh3f libraries of Sweet Home 3D: zip archives of a list (PluginFurnitureCatalog.properties: keys "width#12", sizes in cm)
// and of models (OBJ with y up and the front towards +z, MTL, PNG and JPEG textures).
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "panoptic/sim/model_asset.h"
#include "panoptic/sim/zip_file.h"

namespace panoptic {

struct ArchiveEntry {
  std::string id;    // what follows the '#' in the list: "oakChair"
  std::string name;  // "Oak chair"
  std::string model_path;
  Vec3f size_m = Vec3f::Zero();  // width (x), depth (y), height (z)
  float elevation_m = 0;
  Eigen::Matrix3f rotation = Eigen::Matrix3f::Identity();  // of the OBJ, in its own axes
};

// Not thread-safe: one thread at a time.
class FurnitureArchive {
 public:
  // Reads the list. Throws Error if the archive or its list is damaged.
  explicit FurnitureArchive(const std::filesystem::path& path);

  const std::vector<ArchiveEntry>& entries() const { return entries_; }
  const ArchiveEntry* find(std::string_view id) const;  // nullptr if there is none

  // The model with z up and the front towards -y, at the scale of its file (fit_to_size does the rest). Textures are at most
  // 512 pixels wide and high. Faces that are nearly invisible (opacity below 0.05) are left out; glass becomes opaque, for a
  // depth image needs a surface. A texture outside the archive (an absolute path of its author's) is replaced by the material's
  // colour. Throws Error if the model, its materials or a texture is absent or damaged.
  ModelAsset load(const ArchiveEntry& entry) const;

 private:
  ZipFile zip_;
  std::vector<ArchiveEntry> entries_;
};

}  // namespace panoptic
