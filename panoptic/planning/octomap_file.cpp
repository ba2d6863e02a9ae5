// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/octomap_file.h"

#include <fmt/format.h>
#include <octomap/octomap.h>

#include <cmath>
#include <sstream>

#include "panoptic/error.h"

namespace panoptic {

namespace {

octomap::OcTreeKey key_of(const octomap::OcTree& tree, const Vec3d& at) {
  octomap::OcTreeKey key;
  if (!tree.coordToKeyChecked(at.x(), at.y(), at.z(), key)) {
    throw Error("octomap.bt: the map reaches farther than 32768 cells from its origin, which OctoMap cannot hold");
  }
  return key;
}

// Solid cells are taken for certainly occupied, others whose distance is known for certainly free.
void add_cells(const DistanceField::Values& values, double cell_m, octomap::OcTree& tree) {
  std::size_t i = 0;
  for (int z = 0; z < values.size.z(); ++z) {
    for (int y = 0; y < values.size.y(); ++y) {
      for (int x = 0; x < values.size.x(); ++x, ++i) {
        const float distance = values.distance_m[i];
        if (std::isnan(distance)) continue;
        const Vec3d at = values.origin_m + Vec3d(x, y, z) * cell_m;
        tree.setNodeValue(key_of(tree, at), distance <= 0 ? tree.getClampingThresMaxLog() : tree.getClampingThresMinLog(), true);
      }
    }
  }
}

}  // namespace

std::string octomap_bytes(const DistanceField::Values& values, double cell_m) {
  octomap::OcTree tree(cell_m);
  add_cells(values, cell_m, tree);
  tree.updateInnerOccupancy();
  tree.toMaxLikelihood();
  tree.prune();
  // The header that OcTree::writeBinary writes, which also talks on stderr.
  std::ostringstream stream;
  stream << "# Octomap OcTree binary file\n# (feel free to add / change comments, but leave the first line as it is!)\n#\n"
         << fmt::format("id {}\nsize {}\nres {}\ndata\n", tree.getTreeType(), tree.size(), tree.getResolution());
  if (!tree.writeBinaryData(stream)) throw Error("octomap.bt: OctoMap could not write the tree");
  return stream.str();
}

}  // namespace panoptic
