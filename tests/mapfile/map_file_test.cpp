// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map_file.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <random>

#include "panoptic/base/compression.h"
#include "panoptic/base/files.h"
#include "panoptic/base/sqlite.h"
#include "panoptic/map/label_extents.h"
#include "panoptic/mapfile/block_codec.h"
#include "panoptic/mapfile/map_lock.h"
#include "panoptic/mapfile/map_rows.h"
#include "panoptic/mapfile/map_writer.h"
#include "panoptic/parallel.h"
#include "tests/block_planes.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

using test::error_of;
using test::fresh_folder;
using testing::AllOf;
using testing::HasSubstr;

LabelSet labels() {
  return {"test",
          {{ClassId{1}, "wall", false, {10, 20, 30}, 0, false},
           {ClassId{2}, "table", true, {40, 50, 60}, 2.5, true},
           {ClassId{3}, "chair", true, {70, 80, 90}, 1.25, false}}};
}
constexpr std::uint16_t kFirst = 4;
constexpr std::uint16_t kHeld[] = {0, 1, 2, 3, 4, 6};  // classes and two objects

void fill(BlockPlanes& block, std::mt19937& random) {
  for (std::size_t v = 0; v < kBlockVoxels; ++v) {
    if (random() % 2 == 0) continue;
    block.distance[v] = static_cast<float>(random() % 200) * 1e-3F - 0.1F;
    block.weight[v] = static_cast<float>(random() % 1000 + 1) * 0.01F;
    block.label_weight[v] = static_cast<float>(random() % 1000) * 0.01F;
    block.vote_sum[v] = block.label_weight[v] + static_cast<float>(random() % 3);
    block.label[v] = kHeld[random() % std::size(kHeld)];
    block.red[v] = static_cast<std::uint16_t>(random());
    block.green[v] = static_cast<std::uint16_t>(random());
    block.blue[v] = static_cast<std::uint16_t>(random());
  }
}

// Seven objects; 5 is a part of 4 and something still names its slot, and 8 is retired.
ObjectRegistry some_objects() {
  ObjectRegistry objects(kFirst);
  for (int i = 0; i < 7; ++i) objects.create(i);
  for (int frame = 0; frame < 100; ++frame) {
    const auto id = static_cast<LabelSlot>(kFirst + frame % 4);
    const Segment segment{ClassId{3}, 0.1F * static_cast<float>(frame % 9), {{ClassId{2}, 0.3F}, {ClassId{3}, 1.0F / 3}}};
    objects.observe(id, segment, frame);
    objects.show(id, {frame, ClassId{3}, segment.score, 100U + static_cast<unsigned>(frame), {1, -2, 30, 40}});
  }
  objects.merge(LabelSlot{5}, LabelSlot{4}, 60);
  objects.rule_out(LabelSlot{4}, {ClassId{2}});
  std::vector<bool> in_use(kLabelSlots, true);
  in_use[8] = false;
  objects.retire_unused(in_use);
  objects.create(99);
  return objects;
}

MapOptions coarse() {
  MapOptions options;
  options.voxel_size_m = 0.03F;
  options.truncation_voxels = 3;
  options.max_weight = 70;
  return options;
}

struct World {
  MapHeader header{coarse(), labels()};
  PanopticMap map{labels(), VoxelMap(coarse()), some_objects()};

  explicit World(int blocks = 40, unsigned seed = 1) {
    std::mt19937 random(seed);
    for (int i = 0; i < blocks; ++i) {
      map.voxels.begin_epoch();
      const Slot slot = map.voxels.allocate({i % 5 - 2, -i / 5, i * 7919 % 101});
      if (i % 9 != 0) fill(*test::BlockEdit(map.voxels.block(slot)), random);
      map.free_space.begin_view({{0.1 * i, 1, 2}, Vec3d::UnitY(), 3000 * std::uint64_t{slot}}, map.voxels.epoch());
      map.free_space.observe(map.voxels.index_of(slot), 0x5555, 0xAAAA00000000);
    }
  }
};

void expect_same(const VoxelMap& a, const VoxelMap& b) {
  EXPECT_EQ(a.hash(), b.hash());
  EXPECT_EQ(a.epoch(), b.epoch());
  EXPECT_EQ(a.truncation_m(), b.truncation_m());
  EXPECT_EQ(a.max_weight(), b.max_weight());
  ASSERT_EQ(a.block_count(), b.block_count());
  for (Slot slot = 0; slot < a.block_count(); ++slot) {
    EXPECT_EQ(a.index_of(slot), b.index_of(slot));
    EXPECT_EQ(a.changed_at(slot), b.changed_at(slot));
  }
}

std::filesystem::path saved(const World& world, const std::string& name = "a") {
  const auto path = fresh_folder(name) / "map.panoptic";
  save_map(path, world.header, whole_map(world.map));
  return path;
}

TEST(MapFile, LoadsWhatWasSavedBitForBit) {
  const World world;
  const auto path = fresh_folder() / "map.panoptic";
  MapUpdate update = whole_map(world.map);
  update.notes = {{{"recording", "kitchen"}, {"odd", "'; DROP TABLE blocks; --\n\xC3\xA9"}},
                  {{"bytes", {0, 1, 255}}, {"none", {}}}};
  save_map(path, world.header, update);
  save_map(path, load_map(path));  // over itself
  const SavedMap loaded = load_map(path);
  expect_same(loaded.map.voxels, world.map.voxels);
  EXPECT_EQ(loaded.map.objects.state(), world.map.objects.state());
  EXPECT_EQ(loaded.map.objects.count(), world.map.objects.count());
  EXPECT_EQ(loaded.notes.texts, update.notes.texts);
  EXPECT_EQ(loaded.notes.states, update.notes.states);
  EXPECT_EQ(loaded.map.labels.name(), "test");
  ASSERT_EQ(loaded.map.labels.classes().size(), 3U);
  const LabelClass& table = loaded.map.labels.classes()[1];
  EXPECT_EQ(std::tuple(table.id, table.name, table.is_thing, table.max_size_m, table.is_support),
            std::tuple(ClassId{2}, "table", true, 2.5, true));
  EXPECT_EQ(table.color.g, 50);
}

TEST(MapFile, IsOneFileWithNothingBesideIt) {
  const auto path = saved(World());
  const std::filesystem::directory_iterator files(path.parent_path());
  EXPECT_EQ(std::distance(begin(files), end(files)), 1);
}

TEST(MapFile, WrittenBitByBitIsAsWrittenAtOnce) {
  World world(60);
  const auto path = fresh_folder() / "map.panoptic";
  MapFileWriter writer = MapFileWriter::create(path, world.header, {.epoch = 1});
  EXPECT_EQ(load_map(path).map.voxels.block_count(), 0U) << "a map from the first moment";
  std::mt19937 random(9);
  for (auto [round, seen] = std::pair(0, std::uint64_t{0}); round < 5; ++round) {
    MapUpdate update{
        .epoch = world.map.voxels.epoch(), .space = space_since(world.map.free_space, seen), .objects = world.map.objects};
    for (const Slot slot : world.map.voxels.changed_since(seen)) {
      update.blocks.push_back(
          {slot, world.map.voxels.index_of(slot), world.map.voxels.changed_at(slot), &world.map.voxels.block(slot)});
    }
    update.frames = {{.position = round, .frame = 10 * round, .labelled = round % 2 == 0}};
    update.notes.states["round"] = {static_cast<std::uint8_t>(round)};
    writer.write(update, round % 2 == 0);
    seen = world.map.voxels.epoch();
    expect_same(load_map(path).map.voxels, world.map.voxels);  // while it is open for writing
    EXPECT_EQ(load_map(path).map.free_space.hash(), world.map.free_space.hash());
    EXPECT_EQ(load_map(path).map.objects.state(), world.map.objects.state());
    EXPECT_EQ(load_map(path).notes.states["round"], Bytes{static_cast<std::uint8_t>(round)});
    world.map.voxels.begin_epoch();
    for (Slot slot = 0; slot < world.map.voxels.block_count(); slot += 7) {
      fill(*test::BlockEdit(world.map.voxels.block(slot)), random);
      world.map.voxels.mark_changed(slot);
    }
    world.map.voxels.allocate({100, round, 0});
    world.map.objects.observe(LabelSlot{6}, {ClassId{2}, 0.5F, {}}, 200 + round);
    if (round == 2) world.map.objects.merge(LabelSlot{9}, LabelSlot{6}, 200);
  }
  writer.close();
  EXPECT_EQ(load_frames(path).size(), 5U);
}

TEST(MapFile, GoesOnWhereItWasLoaded) {
  World world;
  const auto path = saved(world);
  world.map.voxels.begin_epoch();
  std::mt19937 random(7);
  fill(*test::BlockEdit(world.map.voxels.block(3)), random);
  world.map.voxels.mark_changed(3);
  MapFileWriter writer = MapFileWriter::open(path, MapLock(path), load_map(path));
  MapUpdate update{.epoch = world.map.voxels.epoch(), .objects = world.map.objects};
  update.blocks = {{3, world.map.voxels.index_of(3), world.map.voxels.changed_at(3), &world.map.voxels.block(3)}};
  writer.write(update, false);
  writer.close();
  expect_same(load_map(path).map.voxels, world.map.voxels);
  // Boxes are those of the whole map, not of what was written last.
  Database database(path, DatabaseAccess::kRead);
  const LabelExtents extents = label_extents(world.map.voxels);
  EXPECT_EQ(database.integer("SELECT voxels FROM objects WHERE id = 4"),
            static_cast<std::int64_t>(extents.at(LabelSlot{4}).voxels));
}

TEST(MapFile, FramesSayWhereTheCameraWasAndWhyTheyWereNotUsed) {
  const World world(1);
  const auto path = fresh_folder() / "map.panoptic";
  MapUpdate update = whole_map(world.map);
  Pose pose = Pose::Identity();
  pose.rotate(Eigen::AngleAxisd(0.7, Vec3d(1, 2, 3).normalized()));
  pose.translation() = Vec3d(1, 2, 3);
  update.frames = {{0, 100, 12.5, pose, true, ""}, {1, 101, 13, std::nullopt, false, "depth image is unreadable: x.png"}};
  save_map(path, world.header, update);
  const std::vector<FrameRecord> frames = load_frames(path);
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_TRUE(frames[0].world_from_camera->isApprox(pose, 1e-12));
  EXPECT_EQ(frames[0].time_s, 12.5);
  EXPECT_TRUE(frames[0].labelled);
  EXPECT_EQ(frames[1].unused_because, "depth image is unreadable: x.png");
  EXPECT_FALSE(frames[1].world_from_camera.has_value());
}

TEST(MapFile, AnswersQuestionsInSql) {
  World world;
  const auto path = saved(world);
  Database database(path, DatabaseAccess::kRead);
  EXPECT_EQ(database.integer("SELECT objects FROM class_summary WHERE class = 'chair'"), 2);
  const LabelExtents extents = label_extents(world.map.voxels);
  const ExtentBox box = box_of(extents.at(LabelSlot{4}), 0.03F);
  Statement row(database, "SELECT class, x_m, size_y_m, probability, observations FROM object_summary WHERE id = 4");
  ASSERT_TRUE(row.step());
  EXPECT_EQ(row.text(0), "chair");
  EXPECT_NEAR(row.real(1), box.center_m.x(), 6e-4);
  EXPECT_NEAR(row.real(2), (box.max_m - box.min_m).y(), 6e-4);
  EXPECT_NEAR(row.real(3), 1.0 / 3, 6e-4);
  EXPECT_EQ(row.integer(4), 50) << "with those of the part";
}

TEST(MapFile, LoadsTheSameAtAnyThreadCount) {
  const auto path = saved(World());
  set_thread_count(1);
  const std::uint64_t one = load_map(path).map.voxels.hash();
  set_thread_count(3);
  EXPECT_EQ(load_map(path).map.voxels.hash(), one);
  set_thread_count(0);
}

// A process that ends while it changes the file without a log leaves parts of the change in it, and a journal to undo them with.
TEST(MapFile, IsAsBeforeAChangeThatWasCutShort) {
  const World world;
  const auto path = saved(world);
  const pid_t child = ::fork();
  if (child == 0) {
    Database database(path, DatabaseAccess::kWrite);
    database.execute("PRAGMA cache_size = 1; BEGIN IMMEDIATE; UPDATE blocks SET voxels = zeroblob(length(voxels))");
    ::_exit(0);  // as if killed
  }
  int status = -1;
  ::waitpid(child, &status, 0);
  ASSERT_EQ(status, 0);
  ASSERT_TRUE(std::filesystem::exists(path.string() + "-journal"));
  EXPECT_THAT(error_of([&] { save_map(path, world.header, whole_map(world.map)); }), HasSubstr("is being written"));
  expect_same(load_map(path).map.voxels, world.map.voxels);
  EXPECT_FALSE(std::filesystem::exists(path.string() + "-journal"));
}

TEST(MapFile, SaysWhatIsWrongWithAPathThatIsNoMap) {
  const auto folder = fresh_folder();
  EXPECT_THAT(error_of([&] { load_map(folder / "absent"); }), HasSubstr("no such file"));
  EXPECT_THAT(error_of([&] { load_map(folder); }), HasSubstr("it is a folder"));
  write_file(folder / "text", "this is not a map, however long it is, and it is long enough to be looked at in earnest");
  EXPECT_THAT(error_of([&] { load_map(folder / "text"); }), AllOf(HasSubstr("text"), HasSubstr("not a database")));
  write_file(folder / "empty", "");
  EXPECT_THAT(error_of([&] { load_map(folder / "empty"); }), HasSubstr("not a map of panoptic"));
}

// The complaint of load_map about a map in which these statements were run.
std::string complaint_after(const std::string& sql) {
  const auto path = saved(World(12));
  Database(path, DatabaseAccess::kWrite).execute(sql.c_str());
  return error_of([&] { load_map(path); });
}

TEST(MapFile, RefusesOtherFormatsAndTables) {
  EXPECT_THAT(complaint_after("PRAGMA application_id = 7"), HasSubstr("not a map of panoptic"));
  EXPECT_THAT(complaint_after("PRAGMA user_version = 7"), HasSubstr("newer panoptic"));
  EXPECT_THAT(complaint_after("PRAGMA user_version = 0"), HasSubstr("format 0"));
  EXPECT_THAT(complaint_after("DROP TABLE frames"), HasSubstr("table frames is missing"));
  EXPECT_THAT(complaint_after("CREATE TABLE mine(x)"), HasSubstr("'mine', which no map has"));
  EXPECT_THAT(complaint_after("CREATE TRIGGER t AFTER INSERT ON blocks BEGIN DELETE FROM blocks; END"), HasSubstr("trigger"));
  EXPECT_THAT(complaint_after("DROP TABLE meta; CREATE TABLE meta(key TEXT, value TEXT)"), HasSubstr("meta is not as format 6"));
  EXPECT_THAT(
      complaint_after("DROP TABLE blocks; CREATE VIEW blocks AS WITH RECURSIVE n(slot) AS (SELECT 0 UNION ALL SELECT slot + 1 "
                      "FROM n) SELECT slot, 0 AS x FROM n"),
      HasSubstr("blocks is not as format 6"));
}

TEST(MapFile, RefusesValuesThatCannotBe) {
  const std::pair<const char*, const char*> cases[] = {
      {"UPDATE meta SET value = 'voxel_size_m = -1.0' WHERE key = 'map'", "voxel_size_m"},
      {"UPDATE meta SET value = '4294967292' WHERE key = 'ids_given'", "ids_given"},
      {"UPDATE meta SET value = '1e3' WHERE key = 'epoch'", "epoch"},
      {"DELETE FROM meta WHERE key = 'epoch'", "lacks 'epoch'"},
      {"UPDATE classes SET id = 2000 WHERE id = 3", "label set"},
      {"UPDATE classes SET name = 'wall'", "label set"},
      {"UPDATE classes SET max_size_m = 9e999", "proper size"},
      {"UPDATE blocks SET x = 2000000 WHERE slot = 2", "column x"},
      {"UPDATE blocks SET x = x + 1 WHERE slot = 2", "block 2: its checksum is wrong"},
      {"UPDATE blocks SET changed_at = 99999 WHERE slot = 2", "column changed_at"},
      {"UPDATE blocks SET voxels = zeroblob(20) WHERE slot = 2", "block 2: its checksum is wrong"},
      {"DELETE FROM blocks WHERE slot = 2", "column slot"},
      {"UPDATE objects SET evidence = '{\"3\": -1}' WHERE id = 4", "object 4 holds"},
      {"UPDATE objects SET evidence = '{\"3\": null}' WHERE id = 4", "object 4 holds"},
      {"UPDATE objects SET evidence = '[' WHERE id = 4", "object 4 holds"},
      {"UPDATE objects SET votes = '{\"log2\": 99, \"bins\": []}' WHERE id = 4", "object 4 holds"},
      {"UPDATE objects SET best_views = '[[1]]' WHERE id = 4", "object 4 holds"},
      {"UPDATE objects SET best_views = '[[1e300,1,1,1,1,1,1,1]]' WHERE id = 4", "object 4 holds"},
      {"UPDATE objects SET best_views = '[[1,1,1e300,1,1,1,1,1]]' WHERE id = 4", "object 4 holds"},
      {"UPDATE objects SET score_sum = 9e999 WHERE id = 4", "object 4 holds"},
      {"INSERT INTO state VALUES('s', 1000000000, 0, x'00')", "its checksum is wrong"},
  };
  for (const auto& [sql, what] : cases) EXPECT_THAT(complaint_after(sql), HasSubstr(what)) << sql;
}

void put_block(const std::filesystem::path& path, Slot slot, BlockIndex i, const Bytes& bytes) {
  Database database(path, DatabaseAccess::kWrite);
  Statement put(database, "INSERT OR REPLACE INTO blocks VALUES(?, ?, ?, ?, 1, ?, ?)");
  put.bind(std::int64_t{slot}).bind(std::int64_t{i.x}).bind(std::int64_t{i.y}).bind(std::int64_t{i.z});
  put.bind(row_checksum({slot, i.x, i.y, i.z, 1}, bytes)).bind(std::span<const std::uint8_t>(bytes)).run();
}

TEST(MapFile, RefusesBlocksWithAGoodChecksumAndBadContents) {
  const World world(12);
  const auto complaint = [&](Slot slot, BlockIndex index, const Bytes& bytes) {
    const auto path = saved(world);
    put_block(path, slot, index, bytes);
    return error_of([&] { load_map(path); });
  };
  auto block = std::make_unique<BlockPlanes>();
  block->weight[5] = 1;
  block->label[5] = kFirst + 8;
  EXPECT_THAT(complaint(12, {50, 0, 0}, BlockEncoder().encode(*block)), HasSubstr("block 12: a voxel has the slot"));
  block->label[5] = 65535;
  EXPECT_THAT(complaint(12, {50, 0, 0}, BlockEncoder().encode(*block)), HasSubstr("block 12: a voxel has the slot"));
  block->label[5] = 1;
  block->distance[5] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(complaint(12, {50, 0, 0}, BlockEncoder().encode(*block)), HasSubstr("not numbers"));
  EXPECT_THAT(complaint(12, world.map.voxels.index_of(3), BlockEncoder().encode({})), HasSubstr("where there is one already"));
  EXPECT_THAT(complaint(12, {50, 0, 0}, {1, 2, 3}), HasSubstr("cannot be decompressed"));
  EXPECT_THAT(complaint(12, {50, 0, 0}, Compressor().compress(Bytes(10'000'000, 0))), HasSubstr("cannot be decompressed"));
}

TEST(MapFile, RefusesMoreBlocksThanTheFileCanHold) {
  const auto path = saved(World(1));
  const Bytes empty = BlockEncoder().encode({});
  {
    Database database(path, DatabaseAccess::kWrite);
    Transaction transaction(database);
    Statement put(database, "INSERT INTO blocks VALUES(?, ?, ?, 0, 1, ?, ?)");
    for (std::int64_t slot = 1; slot < 20000; ++slot) {
      const std::int64_t x = 1000 + slot % 1000;
      const std::int64_t y = slot / 1000;
      put.bind(slot).bind(x).bind(y).bind(row_checksum({slot, x, y, 0, 1}, empty));
      put.bind(std::span<const std::uint8_t>(empty)).run();
    }
    transaction.commit();
  }
  EXPECT_THAT(error_of([&] { load_map(path); }), HasSubstr("more than any map"));
}

// Loading either throws one line or gives a map that can be saved again.
void expect_survives(const std::filesystem::path& path) {
  try {
    const SavedMap map = load_map(path);
    map.map.voxels.hash();
    load_frames(path);
  } catch (const Error& e) {
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
  }
}

TEST(MapFile, SurvivesEveryTruncation) {
  const std::string good = read_file(saved(World(3)));
  const auto path = fresh_folder("bad") / "map.panoptic";
  for (std::size_t size = 0; size < good.size(); size += 331) {
    write_file(path, good.substr(0, size));
    EXPECT_NE(error_of([&] { load_map(path); }), "") << size;
  }
}

TEST(MapFile, SurvivesChangedBytes) {
  const std::string good = read_file(saved(World(3)));
  const auto path = fresh_folder("bad") / "map.panoptic";
  std::mt19937 random(11);
  for (int i = 0; i < 400; ++i) {
    std::string bad = good;
    const std::size_t reach = i % 2 == 0 ? bad.size() : 8192;  // the tables' structure lies in front
    for (int k = 0; k < 1 + i % 5; ++k) bad[random() % reach] = static_cast<char>(random());
    write_file(path, bad);
    expect_survives(path);
  }
}

}  // namespace
}  // namespace panoptic
