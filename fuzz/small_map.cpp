// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "fuzz/small_map.h"

#include <string>

#include "panoptic/base/compression.h"
#include "panoptic/mapfile/map_writer.h"

namespace panoptic::fuzz {

namespace {

ObjectRegistry small_registry() {
  ObjectRegistry objects(small_labels().first_thing());
  for (int i = 0; i < 3; ++i) {
    const auto id = objects.create(i);
    objects.observe(*id, {ClassId{2}, 0.75F, {{ClassId{2}, 0.5F}}}, i + 1);
    objects.show(*id, {i + 1, ClassId{2}, 0.75F, 100, {1, 2, 30, 40}});
  }
  const std::uint16_t first = objects.first_thing();
  objects.merge(static_cast<LabelSlot>(first + 2), static_cast<LabelSlot>(first), 5);
  objects.rule_out(static_cast<LabelSlot>(first), {ClassId{1}});
  return objects;
}

std::vector<FrameRecord> small_frames() {
  std::vector<FrameRecord> frames(2);
  frames[0] = {.position = 0, .frame = 0, .time_s = 0.5, .world_from_camera = Pose::Identity(), .labelled = true};
  frames[1] = {.position = 1, .frame = 1, .time_s = 1, .unused_because = "pose is not finite"};
  return frames;
}

}  // namespace

LabelSet small_labels() {
  return {"small", {{ClassId{1}, "floor", false, {200, 180, 160}}, {ClassId{2}, "chair", true, {31, 119, 180}, 1.5, true}}};
}

PanopticMap small_map() {
  PanopticMap map(small_labels(), VoxelMap(MapOptions{}), small_registry());
  for (const BlockIndex index : {BlockIndex{0, 0, 0}, BlockIndex{1, 0, 0}}) {
    map.voxels.begin_epoch();
    VoxelBlock& block = map.voxels.block(map.voxels.allocate(index));
    for (int v = 0; v < kBlockVoxels; v += index.x == 0 ? 1 : 7) {
      const int layer = v / (kBlockSide * kBlockSide);
      if (layer < 6 || layer > 8 || v % kBlockSide > 9 || v / kBlockSide % kBlockSide > 5) continue;
      const std::uint16_t label = v % kBlockSide < 8 ? 1 : small_labels().first_thing();
      const auto color = static_cast<std::uint16_t>(20000 + v);
      block.set(v, {0.024F * (static_cast<float>(layer) - 7.25F), 2, 2, 2, label, color, color, color});
    }
  }
  return map;
}

Frame small_frame() {
  Frame frame;
  frame.depth_camera = frame.color_camera = {8, 6, 7, 7, 3.5, 2.5};
  frame.depth = Image<float>(8, 6, 1.5F);
  frame.color = Image<Rgb>(8, 6, {90, 80, 70});
  return frame;
}

void save_small_map(const std::filesystem::path& path) {
  const PanopticMap map = small_map();
  MapUpdate update = whole_map(map);
  update.frames = small_frames();
  FrameLog log(1'000'000, LoggedCopies::kInMemory);
  log.add(small_frame());
  update.log = log_since(log, 0);
  update.notes.texts["made_by"] = "a fuzzer";
  update.notes.states["bytes"] = Bytes(100, 7);
  save_map(path, {MapOptions{}, small_labels()}, update);
}

}  // namespace panoptic::fuzz
