// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Objects in a map file: ids, slots, and what was merged.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panoptic/base/sqlite.h"
#include "panoptic/map_file.h"
#include "panoptic/mapfile/map_writer.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

using testing::HasSubstr;

constexpr std::uint16_t kFirst = 4;

// 4 to 11: 5 is a part of 4 and something still names its slot, and 8 is retired.
ObjectRegistry some_objects() {
  ObjectRegistry objects(kFirst);
  for (int i = 0; i < 7; ++i) objects.create(i);
  objects.merge(LabelSlot{5}, LabelSlot{4}, 60);
  std::vector<bool> in_use(kLabelSlots, true);
  in_use[8] = false;
  objects.retire_unused(in_use);
  objects.create(99);
  return objects;
}

// With one block, in which voxels hold the slots 4 and 6.
std::filesystem::path saved(const ObjectRegistry& objects) {
  const MapHeader header{{}, {"test", {{ClassId{1}, "wall", false, {}}, {ClassId{3}, "chair", true, {}}}}};
  PanopticMap map(header.labels, VoxelMap(header.options), objects);
  VoxelBlock& block = map.voxels.block(map.voxels.allocate({0, 0, 0}));
  for (int v = 0; v < kBlockVoxels; ++v) block.set(v, {.weight = 1, .label = v % 2 == 0 ? std::uint16_t{4} : std::uint16_t{6}});
  const auto path = test::fresh_folder() / "map.panoptic";
  save_map(path, header, whole_map(map));
  return path;
}

// Ids beyond 16 bits, a slot that was given anew, one that waits, and an object that could not be created.
TEST(MapFile, KeepsIdsApartFromSlots) {
  RegistryState state = some_objects().state();
  state.objects[2].id = PanopticId{70'000};
  state.objects[3].parts = PartHistory(1, {{PanopticId{65'000}, 5}});
  state.merged.push_back({PanopticId{65'000}, PanopticId{7}});
  state.next_id = PanopticId{70'001};
  state.refused = 3;
  const ObjectRegistry objects(kFirst, state);
  ASSERT_FALSE(state.left.empty());
  const auto path = saved(objects);
  const ObjectRegistry loaded = load_map(path).map.objects;
  EXPECT_EQ(loaded.state(), objects.state());
  EXPECT_EQ(loaded.find(PanopticId{70'000})->slot, LabelSlot{6});
  EXPECT_EQ(loaded.survivor(PanopticId{65'000}), PanopticId{7});
  Database database(path, DatabaseAccess::kRead);
  EXPECT_EQ(database.integer("SELECT slot FROM objects WHERE id = 70000"), 6);
  EXPECT_EQ(database.integer("SELECT merged_into FROM merged WHERE id = 65000"), 7);
}

TEST(MapFile, RefusesObjectsThatContradictEachOther) {
  const std::pair<const char*, const char*> cases[] = {
      {"UPDATE meta SET value = '3' WHERE key = 'ids_given'", "slots_given"},
      {"UPDATE meta SET value = '7' WHERE key = 'ids_given'; UPDATE meta SET value = '7' WHERE key = 'slots_given'", "column"},
      {"UPDATE meta SET value = '-1' WHERE key = 'objects_refused'", "objects_refused"},
      {"UPDATE objects SET parts = '{\"count\": 1, \"latest\": [[0, 1]]}' WHERE id = 4", "object 4 holds"},
      {"UPDATE objects SET parts = '{\"count\": 9, \"latest\": [[5, 1]]}' WHERE id = 4", "object 4 holds"},
      {"UPDATE objects SET parts = '7' WHERE id = 4", "object 4 holds"},
      {"UPDATE objects SET id = 60000 WHERE id = 6", "column id"},
      {"PRAGMA user_version = 1", "as format 1 has it"},
      {"UPDATE objects SET slot = 3 WHERE id = 6", "column slot"},
      {"UPDATE objects SET slot = 60000 WHERE id = 6", "column slot"},
      {"UPDATE objects SET slot = 4 WHERE id = 6", "objects 4 and 6 have one slot"},
      {"UPDATE merged SET merged_into = 5", "object 5 cannot have been merged into 5"},
      {"UPDATE merged SET merged_into = 3", "column merged_into"},
      {"UPDATE merged SET merged_into = 60000", "column merged_into"},
      {"UPDATE merged SET merged_into = 6", "object 5 cannot have been merged into 6"},
      {"UPDATE merged SET id = 60000", "column id"},
      {"INSERT INTO merged VALUES(4, 6)", "cannot have been merged"},
      {"INSERT INTO merged VALUES(8, 5)", "object 8 cannot have been merged into 5"},
      {"UPDATE left_slots SET slot = 4", "object 5 has not left slot 4"},
      {"UPDATE left_slots SET slot = 3", "column slot"},
      {"UPDATE left_slots SET id = 4", "object 4 has not left slot 5"},
      {"DELETE FROM objects WHERE id = 6", "a voxel has the slot of an object that is not there"},
  };
  for (const auto& [sql, what] : cases) {
    const auto path = saved(some_objects());
    Database(path, DatabaseAccess::kWrite).execute(sql);
    EXPECT_THAT(test::error_of([&] { load_map(path); }), HasSubstr(what)) << sql;
  }
}

}  // namespace
}  // namespace panoptic
