// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapfile/space_rows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panoptic/mapfile/map_rows.h"
#include "panoptic/mapfile/map_writer.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

using test::error_of;
using test::fresh_folder;
using testing::HasSubstr;

LabelSet labels() { return {"test", {{ClassId{1}, "wall", false, {10, 20, 30}}}}; }

PanopticMap seen_map() {
  PanopticMap map(MapOptions{}, labels());
  map.free_space.begin_view({{0.1, 1, 2}, Vec3d::UnitY(), 3000}, 1);
  map.free_space.observe({-3, 5, 7}, 0x5555, 0xAAAA00000000);
  map.free_space.observe({40, -5, 7}, ~std::uint64_t{0}, 0);
  map.free_space.set_doubt(cell_of({-3, 5, 7}, 33), {{7, 1, 1}, {1.5F, -2, 0.1F}});
  return map;
}

std::filesystem::path saved(const PanopticMap& map) {
  const auto path = fresh_folder() / "map.panoptic";
  save_map(path, MapHeader{MapOptions{}, labels()}, whole_map(map));
  return path;
}

TEST(SpaceRows, GiveTheSameFreeSpaceAgain) {
  const PanopticMap map = seen_map();
  const SavedMap loaded = load_map(saved(map));
  EXPECT_EQ(loaded.map.free_space.hash(), map.free_space.hash());
  EXPECT_EQ(loaded.map.free_space.record(cell_of({-3, 5, 7}, 33)), map.free_space.record(cell_of({-3, 5, 7}, 33)));
  EXPECT_TRUE(load_map(saved(PanopticMap(MapOptions{}, labels()))).map.free_space.empty());
}

TEST(SpaceRows, RefuseValuesThatCannotBe) {
  const std::pair<const char*, const char*> cases[] = {
      {"UPDATE meta SET value = '' WHERE key = 'free_space'", "seen after the last view"},
      {"UPDATE meta SET value = '0 3 0 0 0 0 0' WHERE key = 'free_space'", "'free_space' tells no view"},
      {"UPDATE meta SET value = '0 3 0 0 nan 0 0 1' WHERE key = 'free_space'", "'free_space' tells no view"},
      {"UPDATE meta SET value = '0 5000 0 0 0 0 0 1' WHERE key = 'free_space'", "'free_space' tells no view"},
      {"UPDATE meta SET value = '0 3 0 0 0 0 0 1' WHERE key = 'free_space'", "seen after the last view"},
      {"DELETE FROM meta WHERE key = 'free_space'", "lacks 'free_space'"},
      {"UPDATE free_space SET x = 3000000 + z", "column x"},
      {"UPDATE free_space SET z = z + 1000", "its checksum is wrong"},
      {"UPDATE free_space SET cells = zeroblob(20)", "its checksum is wrong"},
  };
  for (const auto& [sql, what] : cases) {
    const auto path = saved(seen_map());
    Database(path, DatabaseAccess::kWrite).execute(sql);
    EXPECT_THAT(error_of([&, &path = path] { load_map(path); }), HasSubstr(what)) << sql;
  }
}

TEST(SpaceRows, RefuseBadContentsWithAGoodChecksum) {
  const auto complaint = [](const Bytes& bytes) {
    const auto path = saved(seen_map());
    {
      Database database(path, DatabaseAccess::kWrite);
      Statement put(database, "INSERT INTO free_space VALUES(70, 0, 0, ?, ?)");
      put.bind(row_checksum({70, 0, 0}, bytes)).bind(std::span<const std::uint8_t>(bytes)).run();
    }
    return error_of([&] { load_map(path); });
  };
  SpaceChunk chunk{{70, 0, 0}, 1, {{}}, {}};
  chunk.blocks[0][5] = 0x01000FFF;
  EXPECT_THAT(complaint(encode_chunk(chunk)), HasSubstr("free space at (70, 0, 0): it was seen after the last view"));
  chunk.blocks[0][5] = 0x80000001;
  EXPECT_THAT(complaint(encode_chunk(chunk)), HasSubstr("it holds what no map has"));
  EXPECT_THAT(complaint(Compressor().compress(Bytes(20, 1))), HasSubstr("its bytes have another length"));
  EXPECT_THAT(complaint({1, 2, 3}), HasSubstr("cannot be decompressed"));
  EXPECT_THAT(complaint(Compressor().compress(Bytes(10'000'000, 0))), HasSubstr("cannot be decompressed"));
}

}  // namespace
}  // namespace panoptic
