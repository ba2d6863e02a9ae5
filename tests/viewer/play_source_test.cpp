// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The files that Play asks the server for, and those that a saved page keeps for it.
#include "apps/viewer/play_source.h"

#include <fmt/format.h>

#include "apps/viewer/assets.h"
#include "apps/viewer/saved_page.h"
#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/base/json.h"
#include "panoptic/planning/distance_picture.h"
#include "tests/fresh_folder.h"
#include "tests/viewer/server_fixture.h"

namespace panoptic {
namespace {

using test::HttpAnswer;
using test::solid_ground;
using testing::HasSubstr;
namespace fs = std::filesystem;

constexpr LabelSlot kPlayFloor{1};
constexpr LabelSlot kPlayWall{2};

class ServedPlay : public test::Served {
 protected:
  // A map file of surfaces, 2.4 m wide.
  static std::string map_of(const std::vector<test::Solid>& solids, double high_m = 0.4) {
    const LabelSet labels("small", {{ClassId{1}, "floor", false, {200, 180, 160}}, {ClassId{2}, "wall", false, {90, 90, 90}}});
    const MapOptions options{.voxel_size_m = 0.05F};
    SavedMap saved{options, PanopticMap(options, labels), {}};
    test::add_solids(saved.map.voxels, solids, {-1.2, -0.4, -1.2}, {1.2, high_m, 1.2});
    const fs::path file = test::fresh_folder() / "small.panoptic";
    save_map(file, saved);
    return file.string();
  }
  static std::string map_of_floor() { return map_of({solid_ground(Vec3d::UnitY(), 0, kPlayFloor)}); }
  // With a wall at x = -1 m, 2 m high.
  static std::string map_of_room() {
    return map_of({solid_ground(Vec3d::UnitY(), 0, kPlayFloor), solid_ground(Vec3d::UnitX(), -1, kPlayWall)}, 2);
  }

  void serve(const std::string& map_file) {
    server_ = std::make_unique<ViewerServer>(ViewerOptions{.port = 0}, world_.scene(), latest_, PlaySource(map_file));
    port_ = test::port_of(*server_);
  }
  void expect_refused(const char* name, const std::string& why) const {
    const HttpAnswer answer = get(std::string("/api/play/") + name);
    EXPECT_EQ(answer.status, 404) << name;
    EXPECT_THAT(answer.body, HasSubstr(why)) << name;
  }
};

Pose pose_of(const Json& rows) {
  Pose pose;
  for (int i = 0; i < 16; ++i) pose.matrix()(i / 4, i % 4) = rows[static_cast<std::size_t>(i)];
  return pose;
}

constexpr const char* kPlayFiles[] = {"affordances.json", "navmesh.bin", "walls.bin", "walls.json"};

TEST_F(ServedPlay, WithoutAMapFileTheAnswerSaysHowToGetOne) {
  for (const char* name : kPlayFiles) expect_refused(name, kNoPlay);
  for (const char* name : {"frames.json", "frame.json?n=0", "frame.jpg?n=0", "distances.json", "slice.png?n=0"}) {
    expect_refused(name, "run with --map");
  }
  for (const char* name : {"frame.jpg?n=-1", "slice.png", "slice.png?n=x"}) {
    EXPECT_EQ(get(std::string("/api/play/") + name).status, 400) << name;
  }
  expect_refused("nothing.json", "nothing here");
}

TEST_F(ServedPlay, SlicesOfTheDistancesLieWhereTheirCellsDo) {
  serve(map_of_room());
  const Json about = json("/api/play/distances.json");
  const std::vector<double> heights_m = about["heights_m"];
  ASSERT_GT(heights_m.size(), 30U);
  EXPECT_LT(heights_m.front(), 0);
  EXPECT_GT(heights_m.back(), 1.9);
  const std::size_t level = 30;
  const HttpAnswer slice = get(fmt::format("/api/play/slice.png?n={}", level));
  ASSERT_EQ(slice.status, 200) << slice.body;
  const Image<Rgb> picture = decode_rgb(std::vector<std::uint8_t>(slice.body.begin(), slice.body.end()), "slice");
  const std::vector<double> low_m = about["low_m"];
  const std::vector<double> high_m = about["high_m"];
  ASSERT_GT(heights_m[level], 0.8);
  const Pose grid_from_world = pose_of(about["world_from_grid"]).inverse();
  const auto color_at = [&](double x) {
    const Vec3d place = grid_from_world * Vec3d(x, 1, 0);
    const double u = (place.x() - low_m[0]) / (high_m[0] - low_m[0]) * picture.width();
    const double v = (high_m[1] - place.y()) / (high_m[1] - low_m[1]) * picture.height();
    return picture(static_cast<int>(u), static_cast<int>(v));
  };
  // It meets the wall, and floor and wall are a metre and more away at the other side.
  EXPECT_GT(color_at(-0.96).r, 2 * color_at(-0.96).b);
  EXPECT_LT(color_at(0.9).r, color_at(0.9).b);
  expect_refused(fmt::format("slice.png?n={}", heights_m.size()).c_str(), "there is no slice");
}

TEST_F(ServedPlay, WithoutAFloorTheReasonIsTheSameEveryTime) {
  serve(map_of({solid_ground(Vec3d::UnitX(), 0, kPlayWall)}));
  expect_refused("affordances.json", "no floor");
  const std::string why = get("/api/play/affordances.json").body;
  for (const char* name : kPlayFiles) expect_refused(name, why);
}

TEST_F(ServedPlay, AMapWithoutWallsHasAnEmptyFileOfThem) {
  serve(map_of_floor());
  EXPECT_TRUE(json("/api/play/affordances.json").contains("world_from_grid"));
  EXPECT_FALSE(get("/api/play/navmesh.bin").body.empty());
  const HttpAnswer walls = get("/api/play/walls.bin");
  EXPECT_EQ(walls.status, 200);
  EXPECT_EQ(walls.body, "");
  EXPECT_TRUE(json("/api/play/walls.json")["walls"].empty());
}

TEST_F(ServedPlay, AMapThatNoRunMadeHasNoCameraView) {
  serve(map_of_floor());
  expect_refused("frames.json", "the camera view needs the recording of the map");
  expect_refused("frame.json?n=0", "the camera view needs the recording of the map");
}

TEST_F(ServedPlay, ASavedPageOfAMapWithoutWallsKeepsAllOfThePlan) {
  if (web_assets().empty()) GTEST_SKIP() << "the page was not built";
  const std::string map_file = map_of_floor();
  const fs::path folder = test::fresh_folder("page");
  const SavedPage saved = save_page(folder, {world_.scene(), world_.snapshot()}, PlaySource(map_file), 0);
  const std::string plan = read_file(folder / "data" / "play.js");
  for (const char* name : kPlayFiles) EXPECT_THAT(plan, HasSubstr(std::string("\"/api/play/") + name + "\"")) << name;
  EXPECT_TRUE(saved.notes.empty()) << saved.notes.front();
}

TEST_F(ServedPlay, ASavedPageKeepsSomeOfTheSlices) {
  if (web_assets().empty()) GTEST_SKIP() << "the page was not built";
  const std::string map_file = map_of_room();
  serve(map_file);
  const std::size_t all = json("/api/play/distances.json")["heights_m"].size();
  ASSERT_GT(all, 32U);
  const fs::path folder = test::fresh_folder("page");
  save_page(folder, {world_.scene(), world_.snapshot()}, PlaySource(map_file), 0);
  const std::string distances = read_file(folder / "data" / "distances.js");
  std::size_t kept = 0;
  while (distances.find(fmt::format("\"/api/play/slice.png?n={}\"", kept)) != std::string::npos) ++kept;
  EXPECT_GE(kept, 8U);
  EXPECT_LE(kept, 16U);
  EXPECT_THAT(distances, HasSubstr("\"/api/play/distances.json\""));
}

TEST_F(ServedPlay, ASavedPageNotesWhyThereIsNoPlan) {
  if (web_assets().empty()) GTEST_SKIP() << "the page was not built";
  const fs::path folder = test::fresh_folder("page");
  const SavedPage saved = save_page(folder, {world_.scene(), world_.snapshot()}, PlaySource("", kNoPlay), 5);
  EXPECT_EQ(saved.notes, std::vector<std::string>{kNoPlay});
}

}  // namespace
}  // namespace panoptic
