// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// panoptic plan from outside, and its floor and ways against the truth of a simulated home whose world is turned.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <random>
#include <utility>

#include "panoptic/base/json.h"
#include "panoptic/map_file.h"
#include "panoptic/navigation.h"
#include "panoptic/query.h"
#include "panoptic/sim/simulation.h"
#include "tests/apps/program.h"
#include "tests/fresh_folder.h"
#include "tests/mapping/mapped.h"
#include "tests/planning/home_truth.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;
using test::HomeTruth;
using test::ProgramResult;
using test::run_program;
using testing::HasSubstr;

constexpr double kRadius_m = 0.2;
const Camera kCamera{240, 180, 217.5, 217.5, 119.5, 89.5};

// A home of one room, filmed with perfect masks and depth, and mapped in a world that is turned.
class MappedHome {
 public:
  MappedHome()
      : simulation_({.seed = 3, .rooms = 1, .frames = kFrames, .noise = "none"}),
        truth_(simulation_.home(), AgentSize{}.climb_m, AgentSize{}.height_m),
        path_(test::fresh_folder("home") / "home.panoptic") {
    world_from_home_.linear() = (Eigen::AngleAxisd(-1.2, Vec3d::UnitX()) * Eigen::AngleAxisd(0.5, Vec3d::UnitZ())).matrix();
    world_from_home_.translation() = Vec3d(1, 2, -0.5);
    RunIdentity run{"home", "", "", {}};
    run.options.depth.max_m = 6;
    test::map_views([&](int i) { return view(i); }, 0, kFrames, run, labels_, path_);
    truth_.finish();
    saved_.emplace(load_map(path_));
    frame_ = up_frame(saved_->map);
    floor_.emplace(saved_->map, frame_);
  }

  const HomeTruth& truth() const { return truth_; }
  const fs::path& path() const { return path_; }
  const NavigationMesh& floor() const { return *floor_; }
  const PanopticMap& map() const { return saved_->map; }
  Pose grid_from_home() const { return frame_.grid_from_world * world_from_home_; }
  Vec3d world(const Eigen::Vector2d& at) const { return world_from_home_ * Vec3d(at.x(), at.y(), 0); }

 private:
  static constexpr int kFrames = 90;

  test::LabelledView view(int i) {
    const Pose pose = simulation_.true_path()[static_cast<std::size_t>(i)];
    Rendering r = simulation_.renderer().render(kCamera, pose);
    truth_.see(r, kCamera, pose, labels_.find("floor")->id);
    Frame frame;
    frame.index = i;
    frame.time_s = i / 30.0;
    frame.depth_camera = frame.color_camera = kCamera;
    frame.world_from_camera = world_from_home_ * pose;
    Segmentation segmentation{Image<std::uint16_t>(kCamera.width, kCamera.height), {}};
    std::map<std::pair<ClassId, int>, std::uint16_t> segments;
    for (std::size_t p = 0; p < segmentation.segment_at.size(); ++p) {
      if (r.class_id[p] == ClassId::kUnknown) continue;
      const int instance = labels_.is_thing(r.class_id[p]) ? r.instance[p] : 0;
      const auto [at, is_new] = segments.try_emplace({r.class_id[p], instance}, segments.size() + 1);
      if (is_new) segmentation.segments.push_back({r.class_id[p], 1.0F, {}});
      segmentation.segment_at[p] = at->second;
    }
    frame.depth = std::move(r.depth);
    frame.color = std::move(r.color);
    return {std::move(frame), std::move(segmentation)};
  }

  LabelSet labels_ = load_label_set("scannet20");
  Simulation simulation_;
  HomeTruth truth_;
  fs::path path_;
  Pose world_from_home_ = Pose::Identity();
  std::optional<SavedMap> saved_;
  UpFrame frame_;
  std::optional<NavigationMesh> floor_;
};

const MappedHome& home() {
  static const MappedHome kHome;
  return kHome;
}

// Calls visit for the middles of cells of 4.8 cm, with whether they are truly walkable and whether their neighbours are alike.
template <typename Visit>
void visit_cells(const Visit& visit) {
  constexpr double kCell_m = 0.048;
  const HomeTruth& truth = home().truth();
  const auto is_true = [&](double x, double y) { return truth.floor_clearance_m({x, y}) >= kRadius_m; };
  const Eigen::AlignedBox2d extent = truth.extent();
  for (double y = extent.min().y() + kCell_m; y < extent.max().y() - kCell_m; y += kCell_m) {
    for (double x = extent.min().x() + kCell_m; x < extent.max().x() - kCell_m; x += kCell_m) {
      const bool here = is_true(x, y);
      bool alike = true;
      for (int n = 0; n < 9; ++n) alike = alike && is_true(x + (n % 3 - 1) * kCell_m, y + (n / 3 - 1) * kCell_m) == here;
      visit(Eigen::Vector2d(x, y), here, alike);
    }
  }
}

TEST(Plan, TheWalkableFloorIsTheTrueOne) {
  double both = 0;
  double either = 0;
  visit_cells([&](const Eigen::Vector2d& at, bool is_true, bool alike) {
    if (!alike) return;
    const bool is_found = home().floor().is_walkable(home().grid_from_home() * Vec3d(at.x(), at.y(), 0));
    both += is_true && is_found ? 1 : 0;
    either += is_true || is_found ? 1 : 0;
  });
  ASSERT_GT(both, 200);
  RecordProperty("iou", fmt::format("{:.4f}", both / either));
  EXPECT_GE(both / either, 0.93);
}

TEST(Plan, WaysAreFoundAndTouchNothing) {
  std::vector<Eigen::Vector2d> places;
  visit_cells([&](const Eigen::Vector2d& at, bool is_true, bool alike) {
    if (is_true && alike) places.push_back(at);
  });
  std::mt19937 random(7);
  std::size_t found = 0;
  std::size_t touched = 0;
  constexpr std::size_t kWays = 60;
  for (std::size_t i = 0; i < kWays; ++i) {
    const auto any = [&] { return home().grid_from_home() * Vec3d((Vec3d() << places[random() % places.size()], 0).finished()); };
    const Vec3d from = any();
    const Path path = home().floor().path(from, any());
    found += path.found ? 1U : 0U;
    bool touches = false;
    for (std::size_t p = 1; p < path.points_m.size(); ++p) {
      for (double share = 0; share <= 1; share += 0.02) {
        const Vec3d at =
            home().grid_from_home().inverse() * (path.points_m[p - 1] + share * (path.points_m[p] - path.points_m[p - 1]));
        touches = touches || home().truth().clearance_m(at.head<2>()) < kRadius_m - 0.024 - HomeTruth::kCell_m / 2;
      }
    }
    touched += touches ? 1U : 0U;
  }
  EXPECT_GE(found, kWays * 95 / 100);
  EXPECT_LE(touched, 1U);
}

std::string text_of(const Vec3d& p) { return fmt::format("{:.3f},{:.3f},{:.3f}", p.x(), p.y(), p.z()); }

// The middle of the largest free place of the floor, in the world.
Vec3d free_place() {
  Eigen::Vector2d best(0, 0);
  visit_cells([&](const Eigen::Vector2d& at, bool, bool) {
    if (home().truth().floor_clearance_m(at) > home().truth().floor_clearance_m(best)) best = at;
  });
  return home().world(best);
}

TEST(Plan, TheProgramLeadsToAThingAndWritesItsFiles) {
  const fs::path out = test::fresh_folder("plan");
  const PanopticMap& map = home().map();
  const auto chairs = MapQuery(map).of_class("chair");
  ASSERT_FALSE(chairs.empty());
  const std::string name = fmt::format("chair_{}", number(chairs.front().id));
  const ProgramResult result =
      run_program({"plan", home().path().string(), "-o", out.string(), "--from=" + text_of(free_place()), "--to", name});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("walkable"));
  const Json path = read_json_file(out / "path.json");
  EXPECT_TRUE(path["found"].get<bool>()) << path.dump();
  for (const char* file : {"grid.pgm", "grid.yaml", "semantic.png", "legend.json", "esdf.npy", "esdf.json", "octomap.bt",
                           "navmesh.bin", "navmesh.glb", "navmesh.json", "walls.bin", "walls.json", "path.png"}) {
    EXPECT_TRUE(fs::exists(out / file)) << file;
  }
}

TEST(Plan, PeopleLiveInTheMapAndTheSameSeedGivesTheSameLife) {
  const fs::path out = test::fresh_folder("lived");
  const auto live = [&](const std::string& file) {
    const ProgramResult result =
        run_program({"plan", home().path().string(), "-o", out.string(), "--simulate-agents", "2", "--seconds", "20", "--seed",
                     "7", "--insects", "2", "--json", (out / file).string()});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.out, HasSubstr("agents    2 walked"));
    EXPECT_THAT(result.out, HasSubstr("insects   2 crawled"));
    return read_json_file(out / file);
  };
  fs::create_directories(out);
  write_file(out / "agents.json", "of an earlier plan");
  const Json life = live("first.json");
  EXPECT_FALSE(fs::exists(out / "agents.json"));
  EXPECT_EQ(life.dump(), live("second.json").dump());
  ASSERT_EQ(life["agents"].size(), 2U);
  ASSERT_EQ(life["insects"].size(), 2U);
  EXPECT_EQ(life["insects"][1]["samples"].size(), 201U);
  EXPECT_GT(life["insects_summary"]["crawled_m"].get<double>(), 0.3);
  EXPECT_LT(life["insects_summary"]["farthest_m"].get<double>(), 0.06);
  Eigen::Matrix4d world_from_grid;
  for (int i = 0; i < 16; ++i) world_from_grid(i / 4, i % 4) = life["world_from_grid"][i / 4][i % 4].get<double>();
  const Pose home_from_grid = home().grid_from_home().inverse();
  EXPECT_TRUE((home().world({1, 2}) - Pose(world_from_grid) * (home().grid_from_home() * Vec3d(1, 2, 0))).isZero(1e-6));
  for (const Json& one : life["agents"]) {
    ASSERT_EQ(one["samples"].size(), 201U);
    for (const Json& sample : one["samples"]) {
      const auto p = sample["position"].get<std::vector<double>>();
      const std::string state = sample["state"].get<std::string>();
      if (state != "walking" && state != "standing" && state != "turning") continue;
      const Vec3d at = home_from_grid * Vec3d(p[0], p[1], p[2]);
      ASSERT_NEAR(at.z(), 0, 0.03);
      ASSERT_GE(home().truth().clearance_m(at.head<2>()), kRadius_m - 0.024 - HomeTruth::kCell_m / 2);
    }
  }
}

TEST(Plan, WrongQuestionsAreToldInOneLine) {
  const fs::path out = test::fresh_folder("wrong") / "none";
  const std::string from = "--from=" + text_of(free_place());
  const auto refused = [&](std::vector<std::string> more, int exit_code) {
    std::vector<std::string> all = {"plan", home().path().string(), "-o", out.string()};
    all.insert(all.end(), more.begin(), more.end());
    const ProgramResult result = run_program(all);
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    EXPECT_THAT(result.err, HasSubstr("panoptic: "));
    EXPECT_FALSE(fs::exists(out));
    return result.err;
  };
  EXPECT_THAT(refused({from, "--to", "dragon_7"}, 1), HasSubstr("there is no 'dragon_7'"));
  EXPECT_THAT(refused({from, "--to", "900,900,900"}, 1), HasSubstr("outside"));
  EXPECT_THAT(refused({from, "--to", "1,2"}, 2), HasSubstr("--to takes 3 numbers"));
  EXPECT_THAT(refused({from}, 2), HasSubstr("--to"));
  EXPECT_THAT(refused({"--radius", "nan"}, 1), HasSubstr("a radius"));
  EXPECT_THAT(refused({"--height=-3"}, 1), HasSubstr("a height"));
  EXPECT_THAT(refused({"--band", "1:0.2"}, 1), HasSubstr("the lower one first"));
  EXPECT_THAT(refused({"--band", "1"}, 2), HasSubstr("colons"));
  EXPECT_THAT(refused({"--simulate-agents", "0"}, 1), HasSubstr("1 to 32"));
  EXPECT_THAT(refused({"--simulate-agents", "5", "--seconds", "nan"}, 1), HasSubstr("more than 0"));
  EXPECT_THAT(refused({"--simulate-agents", "5", "--seconds", "8000"}, 1), HasSubstr("at most 7200 s"));
  EXPECT_THAT(refused({"--simulate-agents", "5", "--radius", "2"}, 1), HasSubstr("agents cannot live in this map"));
  EXPECT_THAT(refused({"--simulate-agents", "1", "--json", (home().path() / "life.json").string()}, 1),
              HasSubstr("cannot create the folder"));
  EXPECT_THAT(refused({"--simulate-agents", "1", "--insects", "40"}, 1), HasSubstr("40 insects"));
  EXPECT_THAT(refused({"--insects", "2"}, 2), HasSubstr("--simulate-agents"));
  EXPECT_THAT(refused({"--seconds", "8"}, 2), HasSubstr("--simulate-agents"));
}

}  // namespace
}  // namespace panoptic
