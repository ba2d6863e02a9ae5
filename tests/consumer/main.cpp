// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <panoptic/data/labels.h>
#include <panoptic/map/voxel_map.h>

int main() {
  const panoptic::LabelSet labels = panoptic::load_label_set("indoor");
  panoptic::VoxelMap map(panoptic::MapOptions{});
  const panoptic::Slot slot = map.allocate({0, -1, 2});
  map.block(slot).label[0] = labels.first_thing();
  std::printf("%zu blocks, %zu classes, hash %016llx\n", map.block_count(), labels.classes().size(),
              static_cast<unsigned long long>(map.hash()));
  return map.find({0, -1, 2}) != nullptr ? 0 : 1;
}
