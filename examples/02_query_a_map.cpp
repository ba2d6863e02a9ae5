// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Asks a map file that `panoptic run --map` wrote where things are.
//   02_query_a_map MAP CLASS
#include <panoptic/error.h>
#include <panoptic/map_file.h>
#include <panoptic/query.h>

#include <cstdio>

int main(int argc, char** argv) try {
  if (argc != 3) return std::fprintf(stderr, "usage: %s MAP CLASS\n", argv[0]), 2;
  const panoptic::SavedMap saved = panoptic::load_map(argv[1]);
  const panoptic::MapQuery query(saved.map);
  for (const panoptic::FoundObject& object : query.of_class(argv[2])) {
    const panoptic::Vec3d& p = object.box.center_m;
    std::printf("%s %u is at %.2f %.2f %.2f\n", argv[2], panoptic::number(object.id), p.x(), p.y(), p.z());
    for (const panoptic::NearObject& near : query.nearest(p, 3)) {
      const auto name = saved.map.labels.name_of(near.object.class_id);
      if (near.object.id == object.id) continue;
      std::printf("  near it: %.*s %u\n", static_cast<int>(name.size()), name.data(), panoptic::number(near.object.id));
    }
  }
  return 0;
} catch (const panoptic::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
