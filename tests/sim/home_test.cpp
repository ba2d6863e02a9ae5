// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/home.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <queue>
#include <set>

#include "panoptic/sim/catalogue.h"
#include "panoptic/sim/clearance_map.h"
#include "panoptic/sim/floor_plan.h"
#include "panoptic/sim/home_statistics.h"
#include "panoptic/sim/random.h"
#include "panoptic/sim/walk.h"
#include "tests/expect_error.h"

namespace panoptic {
namespace {

using ::testing::HasSubstr;

const Catalogue& catalogue() {
  static const Catalogue kCatalogue;
  return kCatalogue;
}

// One home per number of rooms, and each of another seed.
const std::vector<Home>& homes() {
  static const std::vector<Home> kHomes = [] {
    std::vector<Home> all;
    for (int rooms = 1; rooms <= 8; ++rooms)
      all.push_back(make_home({static_cast<std::uint64_t>(11 * rooms), rooms}, catalogue()));
    return all;
  }();
  return kHomes;
}

class Hash {
 public:
  void add(const void* data, std::size_t bytes) {
    const auto* first = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < bytes; ++i) value_ = (value_ ^ first[i]) * 0x100000001b3U;
  }
  template <typename T>
  void add(const std::vector<T>& items) {
    add(items.data(), items.size() * sizeof(T));
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325U;
};

std::uint64_t hash_of(const Home& home) {
  Hash hash;
  for (const SceneModel& model : home.scene.models) {
    hash.add(model.name.data(), model.name.size());
    hash.add(model.positions);
    hash.add(model.uvs);
    hash.add(model.triangles);
    hash.add(model.material_of);
  }
  for (const Image<Rgb>& texture : home.scene.textures) hash.add(texture.data(), texture.size() * sizeof(Rgb));
  for (const Material& material : home.scene.materials) {
    hash.add(&material.color, sizeof(material.color));
    hash.add(&material.texture, sizeof(material.texture));
  }
  for (const SceneObject& object : home.scene.objects) {
    hash.add(object.name.data(), object.name.size());
    hash.add(&object.model, sizeof(object.model));
    hash.add(&object.instance, sizeof(object.instance));
    hash.add(object.world_from_object.matrix().data(), 16 * sizeof(double));
    hash.add(object.scale.data(), 3 * sizeof(float));
  }
  for (const Lamp& lamp : home.scene.lamps) hash.add(lamp.position.data(), 3 * sizeof(float));
  return hash.value();
}

const SceneObject& object_of(const Home& home, std::uint16_t instance) {
  return *std::find_if(home.scene.objects.begin(), home.scene.objects.end(),
                       [&](const SceneObject& it) { return it.instance == instance; });
}

std::string class_of(const Home& home, const ThingBox& thing) {
  static const LabelSet kLabels = load_label_set("scannet20");
  return std::string(kLabels.name_of(object_of(home, thing.instance).class_id));
}

TEST(Random, IsTheSameOnEveryMachine) {
  EXPECT_EQ(mix_bits(0), 0xe220a8397b1dcdafU);  // the first number of splitmix64 from state 0, as its author published it
  Random random(1, 2, 3);
  Random again(1, 2, 3);
  EXPECT_EQ(random.bits(), again.bits());
  EXPECT_NE(Random(1, 2, 3).bits(), Random(1, 2, 4).bits());
  EXPECT_NE(Random(1, 2, 3).bits(), Random(1, 3, 3).bits());
}

TEST(Random, DrawsEvenlyWithinTheRange) {
  Random random(5);
  std::array<int, 6> count{};
  double sum = 0;
  for (int i = 0; i < 6000; ++i) {
    ++count.at(static_cast<std::size_t>(random.integer(0, 5)));
    sum += random.normal();
  }
  for (const int times : count) EXPECT_NEAR(times, 1000, 120);
  EXPECT_NEAR(sum / 6000, 0, 0.05);
}

TEST(FloorPlan, RefusesNumbersOfRoomsOutOfRange) {
  for (const int rooms : {-1, 0, 9, 1'000'000'000}) {
    EXPECT_THAT(test::error_of([&] { make_home({1, rooms}, catalogue()); }), HasSubstr("1 to 8 rooms")) << rooms;
  }
}

TEST(FloorPlan, SucceedsForAHundredSeedsOfEverySize) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    for (int rooms = 1; rooms <= 8; ++rooms) {
      const FloorPlan plan = make_floor_plan({seed, rooms});
      ASSERT_EQ(plan.rooms.size(), static_cast<std::size_t>(rooms));
      for (std::uint32_t i = 0; i < plan.rooms.size(); ++i) {
        const Eigen::AlignedBox2d& floor = plan.rooms[i].floor;
        EXPECT_GE(floor.volume(), 8);
        EXPECT_LE(floor.volume(), 40);
        EXPECT_GE(floor.sizes().minCoeff(), 2.2);
        for (std::uint32_t j = 0; j < i; ++j) {
          const Eigen::AlignedBox2d& other = plan.rooms[j].floor;
          EXPECT_GE(floor.exteriorDistance(other), kInnerWall_m - 1e-9);
        }
      }
    }
  }
}

// Flood fill over doorways, the naive way.
TEST(FloorPlan, ConnectsAllRoomsAndHasOneEntrance) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const FloorPlan plan = make_floor_plan({seed, 1 + static_cast<int>(seed % 8)});
    std::set<std::uint32_t> reached = {0};
    for (std::size_t round = 0; round < plan.rooms.size(); ++round) {
      for (const Doorway& doorway : plan.doorways) {
        if (reached.contains(doorway.room_a) || reached.contains(doorway.room_b))
          reached.insert({doorway.room_a, doorway.room_b});
      }
    }
    EXPECT_EQ(reached.size(), plan.rooms.size()) << "seed " << seed;
    EXPECT_EQ(
        std::count_if(plan.holes.begin(), plan.holes.end(), [](const WallHole& hole) { return hole.kind == Hole::kEntrance; }),
        1);
  }
}

TEST(FloorPlan, KeepsOpeningsApartAndWithinTheirWalls) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const FloorPlan plan = make_floor_plan({seed, 1 + static_cast<int>(seed % 8)});
    for (const WallHole& hole : plan.holes) {
      EXPECT_GT(hole.low_m(), 0.05);
      EXPECT_LT(hole.high_m(), wall_face(plan.rooms[hole.room].floor, hole.side).length_m - 0.05);
      for (const WallHole& other : plan.holes) {
        if (&other == &hole || other.room != hole.room || other.side != hole.side) continue;
        EXPECT_TRUE(other.low_m() > hole.high_m() || other.high_m() < hole.low_m()) << "seed " << seed;
      }
    }
  }
}

TEST(Home, IsTheSameByteForByteForTheSameSeed) {
  const Catalogue other_catalogue;
  EXPECT_EQ(hash_of(make_home({7, 3}, catalogue())), hash_of(make_home({7, 3}, other_catalogue)));
  EXPECT_NE(hash_of(make_home({7, 3}, catalogue())), hash_of(make_home({8, 3}, catalogue())));
}

// In every build: no compiler may draw the random numbers in another order.
TEST(Home, HashIsGolden) { EXPECT_EQ(hash_of(make_home({7, 3}, catalogue())), 162369081939573154U); }

TEST(Home, NumbersItsThingsFromOneAndItsStuffZero) {
  const LabelSet labels = load_label_set("scannet20");
  for (const Home& home : homes()) {
    std::set<std::uint16_t> instances;
    for (const SceneObject& object : home.scene.objects) {
      EXPECT_EQ(labels.is_thing(object.class_id), object.instance != 0) << object.name;
      if (object.instance != 0) {
        EXPECT_TRUE(instances.insert(object.instance).second);
      }
    }
    EXPECT_EQ(*instances.begin(), 1);
    EXPECT_EQ(*instances.rbegin(), instances.size());
  }
}

TEST(Home, HoldsEveryClassOfTheBenchmarkWithinAFewSeeds) {
  std::set<std::string> found;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Home home = make_home({seed, 5}, catalogue());
    const HomeStatistics numbers = statistics(home);
    for (const auto& [name, count] : numbers.objects_of) found.insert(name);
  }
  found.insert({"wall", "floor"});
  const LabelSet labels = load_label_set("scannet20");
  for (const LabelClass& it : labels.classes()) EXPECT_TRUE(found.contains(it.name)) << it.name;
}

// Chairs may stand partly below tables, and nothing else runs into anything.
TEST(Home, LetsNothingRunIntoAnythingElse) {
  for (const Home& home : homes()) {
    const std::vector<ThingBox> things = thing_boxes(home.scene);
    for (std::size_t i = 0; i < things.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const ThingBox& a = things[i];
        const ThingBox& b = things[j];
        if (a.top_m <= b.bottom_m + 0.01 || b.top_m <= a.bottom_m + 0.01 || !overlap(a.base, b.base, 0.01)) continue;
        const std::set<std::string> pair = {class_of(home, a), class_of(home, b)};
        const bool is_seat = pair.contains("chair") && (pair.contains("table") || pair.contains("desk"));
        EXPECT_TRUE(is_seat) << object_of(home, a.instance).name << " runs into " << object_of(home, b.instance).name
                             << ", rooms " << home.rooms.size();
      }
    }
  }
}

TEST(Home, KeepsThingsWithinTheirRoomsOrInTheirWalls) {
  for (const Home& home : homes()) {
    for (const ThingBox& thing : thing_boxes(home.scene)) {
      const std::string name = class_of(home, thing);
      if (name == "window" || name == "door") continue;
      const Eigen::AlignedBox2d box = bounds(thing.base);
      const bool is_within = std::any_of(home.rooms.begin(), home.rooms.end(), [&](const Room& room) {
        return (box.min() - room.floor.min()).minCoeff() > -0.01 && (room.floor.max() - box.max()).minCoeff() > -0.01;
      });
      EXPECT_TRUE(is_within) << object_of(home, thing.instance).name;
      EXPECT_GE(thing.bottom_m, -0.01);
      EXPECT_LE(thing.top_m, home.wall_height_m + 0.01) << object_of(home, thing.instance).name;
    }
  }
}

// A person 0.6 m wide, on a grid of the test's own.
TEST(Home, LetsAPersonReachEveryDoorway) {
  for (const Home& home : homes()) {
    const ClearanceMap clearance = walking_clearance(home, 1.9);
    const auto reached = [&] {
      std::set<int> seen;
      std::queue<int> open;
      const auto visit = [&](int cell) {
        if (clearance[cell] >= 0.27 && seen.insert(cell).second) open.push(cell);
      };
      visit(clearance.cell_at(home.doorways.front().center));
      while (!open.empty()) {
        const int cell = open.front();
        open.pop();
        for (const int step : {1, -1, clearance.width(), -clearance.width()}) visit(cell + step);
      }
      return seen;
    };
    if (home.doorways.empty()) continue;
    const std::set<int> cells = reached();
    for (const Doorway& doorway : home.doorways) EXPECT_TRUE(cells.contains(clearance.cell_at(doorway.center)));
  }
}

TEST(Home, HasALampBelowEveryCeiling) {
  for (const Home& home : homes()) {
    for (const Room& room : home.rooms) {
      EXPECT_TRUE(std::any_of(home.scene.lamps.begin(), home.scene.lamps.end(), [&](const Lamp& lamp) {
        return room.floor.contains(Eigen::Vector2d(lamp.position.head<2>().cast<double>())) &&
               lamp.position.z() < home.wall_height_m;
      }));
    }
  }
}

// Walls without holes would be all of the face; every opening takes its area away.
TEST(Home, OpensItsWallsExactlyWhereDoorsAndWindowsAre) {
  const FloorPlan plan = make_floor_plan({33, 3});
  const Home& home = homes()[2];
  const double scene_area_m2 = [&] {
    double area_m2 = 0;
    const SceneModel& walls = home.scene.models[home.scene.objects[0].model];
    for (const auto& [a, b, c] : walls.triangles) {
      const Vec3f& p = walls.positions[a];
      const Vec3f normal = (walls.positions[b] - p).cross(walls.positions[c] - p);
      const Eigen::Vector2d middle = (p + (walls.positions[b] - p) / 3 + (walls.positions[c] - p) / 3).head<2>().cast<double>();
      if (home.rooms[0].floor.exteriorDistance(middle) < 1e-5) area_m2 += normal.norm() / 2;  // without the reveals
    }
    return area_m2;
  }();
  double expected_m2 = 2 * home.rooms[0].floor.sizes().sum() * home.wall_height_m;
  for (const WallHole& hole : plan.holes) {
    if (hole.room == 0) expected_m2 -= hole.width_m * (hole.top_m - hole.bottom_m);
  }
  EXPECT_NEAR(scene_area_m2, expected_m2, 1e-3);
}

TEST(HomeStatistics, CountsThingsAndDrawsThePlan) {
  const Home& home = homes()[3];
  const HomeStatistics numbers = statistics(home);
  int sum = 0;
  for (const auto& [name, count] : numbers.objects_of) sum += count;
  EXPECT_EQ(sum, numbers.objects);
  EXPECT_GT(numbers.objects, 30);
  EXPECT_THAT(to_text(numbers, home), HasSubstr("m2 in 4 rooms"));
  const Image<Rgb> plan = draw_plan(home);
  std::set<std::tuple<int, int, int>> colors;
  for (const Rgb& color : plan.pixels()) colors.insert({color.r, color.g, color.b});
  EXPECT_GT(colors.size(), 12U);  // paper, floor, ink and the classes
}

}  // namespace
}  // namespace panoptic
