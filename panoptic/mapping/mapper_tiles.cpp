// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <optional>
#include <utility>

#include "panoptic/crf/tiles.h"
#include "panoptic/mapping/mapper_parts.h"

namespace panoptic {
namespace {

// Copying a tile holds mapping up, so they are no larger than this, whatever regularizer.max_blocks says.
constexpr std::size_t kMostBlocksAtOnce = 64;

}  // namespace

std::vector<std::vector<Slot>> MapperParts::choose_tiles() {
  if (!regularizes_) return {};
  std::vector<std::vector<Slot>> tiles;
  for (const std::vector<Slot>& blocks : regularizer_.choose(map_.voxels)) {
    if (blocks.size() <= kMostBlocksAtOnce) {
      tiles.push_back(blocks);
    } else {
      for (std::vector<Slot>& part : divide_into_tiles(map_.voxels, blocks, kMostBlocksAtOnce)) tiles.push_back(std::move(part));
    }
  }
  return tiles;
}

TileGraph MapperParts::gather(const std::vector<Slot>& blocks) const {
  TileGraph tile = regularizer_.gather(map_.voxels, blocks);
  tile.next_id = map_.objects.next_id();
  return tile;
}

// The label now of what a label named when `next_id` was the registry's. Nothing if the object is no more, or if its slot was
// given anew since.
std::optional<std::uint16_t> MapperParts::now_called(std::uint16_t label, PanopticId next_id) const {
  const auto slot = static_cast<LabelSlot>(label);
  if (!map_.labels.is_object(slot)) return label;
  const PanopticId id = map_.objects.named_by(slot);
  const Object* object = map_.objects.find(map_.objects.survivor(id));
  return object == nullptr || id >= next_id ? std::nullopt : std::optional(number(object->slot));
}

void MapperParts::write_back(TileChanges changes) {
  std::erase_if(changes.changes, [&](LabelChange& change) {
    CoreVoxel& before = change.before;
    const auto held = now_called(before.held.label, changes.next_id);
    const auto voted = now_called(before.voted.label, changes.next_id);
    const auto label = now_called(change.label.label, changes.next_id);
    if (!held || !voted || !label) return true;
    before.held.label = *held;
    before.voted.label = *voted;
    change.label.label = *label;
    if (change.label.label == before.voted.label) change.label.weight = std::min(before.voted.weight, before.vote_sum);
    return change.label.label == before.held.label;
  });
  map_.voxels.begin_epoch();
  regularizer_.write_back(changes, map_.voxels);
}

}  // namespace panoptic
