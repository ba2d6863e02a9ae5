// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Tells what changed from one map file to another of the same place, and makes one map of both.
//   03_merge_two_maps BEFORE AFTER MERGED
#include <panoptic/error.h>
#include <panoptic/map_pairs.h>

#include <cstdio>

int main(int argc, char** argv) try {
  if (argc != 4) return std::fprintf(stderr, "usage: %s BEFORE AFTER MERGED\n", argv[0]), 2;
  const panoptic::MapWithFrames before = panoptic::load_map_with_frames(argv[1]);
  const panoptic::MapWithFrames after = panoptic::load_map_with_frames(argv[2]);
  for (const panoptic::ObjectChange& change : panoptic::diff_maps(before, after, argv[1], argv[2]).changes) {
    const panoptic::FoundObject& object = change.before ? *change.before : *change.after;
    const auto kind = panoptic::name_of(change.kind);
    const auto name = before.saved.map.labels.name_of(object.class_id);
    const panoptic::Vec3d& p = object.box.center_m;
    std::printf("%.*s: %.*s at %.2f %.2f %.2f\n", static_cast<int>(kind.size()), kind.data(), static_cast<int>(name.size()),
                name.data(), p.x(), p.y(), p.z());
  }
  const panoptic::MergedFiles merged = panoptic::merge_map_files(argv[1], argv[2], argv[3]);
  std::printf("%zu objects in %s, %zu of them in both maps\n", merged.objects, argv[3], merged.same);
  return 0;
} catch (const panoptic::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
