// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <octomap/octomap.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <set>
#include <tuple>
#include <vector>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/base/json.h"
#include "panoptic/planning.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/planning/furnished.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

PanopticMap& rooms() {
  static PanopticMap map = test::furnished_map();
  return map;
}

PlanOptions to_chair() {
  PlanOptions options;
  options.bands = {{0.3, 0.9}};
  options.journey = Journey{.from_m = {-1, 0, 0}, .to_m = {}, .to_object = "chair_4"};
  options.up = Vec3d::UnitZ();
  return options;
}

// Written once.
const fs::path& folder() {
  static const fs::path kFolder = [] {
    const fs::path folder = test::fresh_folder("plan");
    write_plan(folder, rooms(), to_chair());
    return folder;
  }();
  return kFolder;
}

// The byte of a grid at a place of the z-up frame, as map_server finds it.
int byte_at(const char* name, double x, double y) {
  const std::string yaml = read_file(folder() / (std::string(name) + ".yaml"));
  double resolution = 0;
  double origin_x = 0;
  double origin_y = 0;
  EXPECT_EQ(std::sscanf(yaml.c_str() + yaml.find("resolution:"), "resolution: %lf\norigin: [%lf, %lf, 0]", &resolution, &origin_x,
                        &origin_y),
            3);
  const Image<std::uint16_t> grid = read_gray16(folder() / (std::string(name) + ".pgm"));
  return grid(static_cast<int>((x - origin_x) / resolution), grid.height() - 1 - static_cast<int>((y - origin_y) / resolution));
}

TEST(WritePlan, GridsAreThoseOfMapServer) {
  EXPECT_EQ(byte_at("grid", -1, 0), 254);
  EXPECT_EQ(byte_at("grid", 1.12, -0.7), 0);
  EXPECT_EQ(byte_at("grid", 2.06, 1.6), 205);
  EXPECT_EQ(byte_at("grid", -1.7, -1.1), 0) << "under the shelf";
  EXPECT_EQ(byte_at("grid_0.3_0.9", -1.7, -1.1), 254) << "the band is below the shelf";
  EXPECT_THAT(read_file(folder() / "grid.yaml"), HasSubstr("free_thresh: 0.196"));
}

TEST(WritePlan, DistancesAreANumPyArray) {
  const Json json = read_json_file(folder() / "esdf.json");
  const std::string bytes = read_file(folder() / "esdf.npy");
  ASSERT_EQ(bytes.substr(1, 5), "NUMPY");
  const std::size_t header = 10 + static_cast<unsigned char>(bytes[8]) + 256U * static_cast<unsigned char>(bytes[9]);
  EXPECT_EQ(header % 64, 0U);
  const auto shape = json["shape_zyx"].get<std::vector<std::size_t>>();
  ASSERT_EQ(bytes.size(), header + shape[0] * shape[1] * shape[2] * sizeof(float));
  const auto value_at = [&](const Vec3d& p) {
    std::array<std::size_t, 3> cell{};
    for (std::size_t a = 0; a < 3; ++a) {
      cell[a] = static_cast<std::size_t>(
          std::lround((p[static_cast<Eigen::Index>(a)] - json["origin_m"][a].get<double>()) / json["cell_m"].get<double>()));
    }
    float value = 0;
    std::memcpy(&value, bytes.data() + header + (cell[0] + shape[2] * (cell[1] + shape[1] * cell[2])) * sizeof(float),
                sizeof(value));
    return value;
  };
  EXPECT_NEAR(value_at({-1, -0.5, 0.6}), 0.6, 0.05);
  EXPECT_NEAR(value_at({0.8, -0.7, 0.6}), 0.3, 0.05);
  EXPECT_EQ(json["cap_m"], 2);
}

TEST(WritePlan, EveryJsonSaysWhereItIsInTheWorld) {
  std::size_t count = 0;
  for (const std::string& name : names_in_folder(folder())) {
    if (!name.ends_with(".json")) continue;
    const Json json = read_json_file(folder() / name);
    ASSERT_TRUE(json.contains("world_from_grid")) << name;
    EXPECT_EQ(json["world_from_grid"].size(), 4U);
    EXPECT_EQ(json["world_from_grid"][3], Json({0, 0, 0, 1}));
    ++count;
  }
  EXPECT_EQ(count, 7U);
}

TEST(WritePlan, ThePathIsAListOfPlaces) {
  const Json json = read_json_file(folder() / "path.json");
  ASSERT_TRUE(json["found"].get<bool>());
  const auto points = json["points"].get<std::vector<std::array<double, 3>>>();
  double length = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    length += (Vec3d(points[i].data()) - Vec3d(points[i - 1].data())).norm();
  }
  EXPECT_NEAR(length, json["length_m"].get<double>(), 1e-9);
  EXPECT_GT(length, 1.5);
  EXPECT_NEAR(points.front()[0], -1, 0.05);
  const Image<Rgb> picture = read_rgb(folder() / "path.png");
  std::set<std::tuple<int, int, int>> colors;
  for (const Rgb& pixel : picture.pixels()) colors.insert({pixel.r, pixel.g, pixel.b});
  EXPECT_GT(colors.size(), 10U);
}

TEST(WritePlan, TheOctreeHoldsOccupiedAndFree) {
  octomap::OcTree tree((folder() / "octomap.bt").string());
  EXPECT_NEAR(tree.getResolution(), 0.048, 1e-6);
  const auto* floor = tree.search(-1, 0, -0.01);
  const auto* air = tree.search(-1, 0, 0.5);
  ASSERT_NE(floor, nullptr);
  ASSERT_NE(air, nullptr);
  EXPECT_TRUE(tree.isNodeOccupied(floor));
  EXPECT_FALSE(tree.isNodeOccupied(air));
  EXPECT_EQ(tree.search(20, 0, 0), nullptr);
}

TEST(WritePlan, TheLegendNamesTheClassesOfTheGrid) {
  const Json legend = read_json_file(folder() / "legend.json");
  std::set<std::string> names;
  for (const Json& c : legend["classes"]) names.insert(c["name"].get<std::string>());
  EXPECT_THAT(names, testing::IsSupersetOf({"wall", "floor", "chair"}));
  const Image<Rgb> image = read_rgb(folder() / "semantic.png");
  const auto pixel_at = [&](double x, double y) {
    const double cell = legend["cell_m"];
    return image(static_cast<int>((x - legend["origin_m"][0].get<double>()) / cell),
                 image.height() - 1 - static_cast<int>((y - legend["origin_m"][1].get<double>()) / cell));
  };
  EXPECT_EQ(pixel_at(1.3, -0.7), (Rgb{0, 0, 200}));
  EXPECT_EQ(pixel_at(-1, 0), (Rgb{0, 200, 0}));
}

TEST(WritePlan, NavigationMeshesBeginAsDetoursFilesDo) {
  EXPECT_EQ(read_file(folder() / "navmesh.bin").substr(0, 4), "TESM");
  const Json walls = read_json_file(folder() / "walls.json");
  const std::string bytes = read_file(folder() / "walls.bin");
  EXPECT_GE(walls["walls"].size(), 6U);
  for (const Json& wall : walls["walls"]) {
    EXPECT_EQ(bytes.substr(wall["offset"].get<std::size_t>(), 4), "TESM");
    EXPECT_GT(wall["polygons"].get<int>(), 0);
    const auto& rows = wall["grid_from_wall"];
    EXPECT_NEAR(rows[2][2].get<double>(), 0, 1e-6) << "a wall's normal is level";
  }
}

TEST(WritePlan, AWayThatIsNotThereIsSaid) {
  const fs::path other = test::fresh_folder("none");
  PlanOptions options = to_chair();
  options.agent.radius_m = 0.48;
  options.journey->from_m = {-0.8, -0.2, 0};
  const PlanSummary summary = write_plan(other, rooms(), options);
  EXPECT_FALSE(summary.length_m.has_value());
  EXPECT_THAT(summary.why_not, HasSubstr("no way"));
  const Json json = read_json_file(other / "path.json");
  EXPECT_FALSE(json["found"].get<bool>());
  EXPECT_TRUE(json["points"].empty());
}

TEST(WritePlan, WithoutAJourneyAnOlderPathIsRemoved) {
  const fs::path other = test::fresh_folder("older");
  write_file(other / "path.json", "{}");
  PlanOptions options;
  options.up = Vec3d::UnitZ();
  write_plan(other, rooms(), options);
  EXPECT_FALSE(is_there(other / "path.json"));
}

TEST(WritePlan, AMapWithoutFreeSpaceSaysWhatThatMeans) {
  const fs::path other = test::fresh_folder("notes");
  PlanOptions options;
  options.up = Vec3d::UnitZ();
  EXPECT_THAT(write_plan(other, rooms(), options).notes, testing::Contains(HasSubstr("no free space")));
}

TEST(WritePlan, BandsThatAreNoneAreRefused) {
  PlanOptions options;
  options.bands = {{1, 0.5}};
  EXPECT_THAT(test::error_of([&] { write_plan("never", rooms(), options); }), HasSubstr("the lower one first"));
  options.bands = {{0, std::nan("")}};
  EXPECT_THAT(test::error_of([&] { write_plan("never", rooms(), options); }), HasSubstr("a band"));
  options.bands = {{0, 1}, {0, 1}};
  EXPECT_THAT(test::error_of([&] { write_plan("never", rooms(), options); }), HasSubstr("one file"));
  EXPECT_FALSE(is_there("never"));
}

}  // namespace
}  // namespace panoptic
