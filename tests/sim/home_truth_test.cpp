// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/home_truth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "panoptic/base/json.h"
#include "panoptic/labels.h"
#include "panoptic/sim/catalogue.h"
#include "panoptic/sim/clearance_map.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

constexpr HomeOptions kOptions{44, 4};

const Home& home() {
  static const Home kHome = make_home(kOptions, Catalogue());
  return kHome;
}
const PlanTruth& truth() {
  static const PlanTruth kTruth = home_truth(home(), kOptions);
  return kTruth;
}

std::set<std::uint16_t> things_of(std::initializer_list<std::string_view> names) {
  const LabelSet labels = load_label_set("scannet20");
  std::set<std::uint16_t> things;
  for (const SceneObject& object : home().scene.objects) {
    const std::string_view name = labels.name_of(object.class_id);
    if (std::find(names.begin(), names.end(), name) != names.end()) things.insert(object.instance);
  }
  return things;
}

std::map<std::uint16_t, ThingBox> boxes() {
  std::map<std::uint16_t, ThingBox> by_instance;
  for (const ThingBox& box : thing_boxes(home().scene)) by_instance[box.instance] = box;
  return by_instance;
}

TEST(PlanTruth, EveryChairAndSofaHasASeatWithinItsBox) {
  std::set<std::uint16_t> seated;
  for (const TrueSeat& seat : truth().seats) {
    const ThingBox box = boxes().at(seat.instance);
    EXPECT_LT(distance_m(box.base, seat.position.head<2>()), 1e-6);
    EXPECT_GT(seat.position.z(), 0.25);
    EXPECT_LT(seat.position.z(), 0.65);
    EXPECT_NEAR(seat.facing.dot(-box.base.across()), 1, 1e-6);
    seated.insert(seat.instance);
  }
  EXPECT_EQ(seated, things_of({"chair", "sofa"}));
}

TEST(PlanTruth, TableTopsFillTheirThings) {
  std::set<std::uint16_t> topped;
  for (const TrueLevel& top : truth().table_tops) {
    const ThingBox box = boxes().at(top.instance);
    EXPECT_GT(signed_area(top.polygon), 0.6 * 4 * box.base.half_m.prod());
    EXPECT_NEAR(top.height_m, box.top_m, 1e-3);
    topped.insert(top.instance);
  }
  EXPECT_EQ(topped, things_of({"table", "desk", "counter"}));
}

TEST(PlanTruth, BedsAreLainOn) {
  std::set<std::uint16_t> lying;
  for (const TrueLevel& place : truth().lying_places) lying.insert(place.instance);
  for (const std::uint16_t bed : things_of({"bed"})) EXPECT_TRUE(lying.contains(bed)) << bed;
}

TEST(PlanTruth, DoorsLieBetweenTheirRoomsAndOneIsClosed) {
  ASSERT_EQ(truth().rooms.size(), 4U);
  EXPECT_EQ(truth().doors.size(), home().doorways.size() + 1);
  EXPECT_EQ(std::count_if(truth().doors.begin(), truth().doors.end(), [](const TrueDoor& d) { return !d.is_open; }), 1);
  for (const TrueDoor& door : truth().doors) {
    EXPECT_EQ(door.rooms.size(), door.is_open ? 2U : 1U);
    const Vec2d across = quarter_turn(door.along);
    for (const std::uint32_t room : door.rooms) {
      const Polygon& polygon = truth().rooms[room].polygon;
      EXPECT_TRUE(contains(polygon, door.center + across * 0.2) || contains(polygon, door.center - across * 0.2));
      EXPECT_FALSE(contains(polygon, door.center));
    }
  }
}

TEST(PlanTruth, FilesSayTheSame) {
  const auto folder = test::fresh_folder();
  write_home_truth(truth(), folder);
  const Json affordances = read_json_file(folder / "affordances_truth.json");
  EXPECT_EQ(affordances.at("seats").size(), truth().seats.size());
  EXPECT_EQ(affordances.at("table_tops").size(), truth().table_tops.size());
  EXPECT_EQ(affordances.at("doors").size(), truth().doors.size());
  EXPECT_EQ(affordances.at("world_from_grid").size(), 4U);
  const Json rooms = read_json_file(folder / "rooms_truth.json").at("rooms");
  ASSERT_EQ(rooms.size(), 4U);
  EXPECT_EQ(rooms.at(0).at("class"), "living room");
  EXPECT_FALSE(rooms.at(0).at("objects").empty());
  EXPECT_FALSE(rooms.at(0).at("doors").empty());
}

}  // namespace
}  // namespace panoptic
