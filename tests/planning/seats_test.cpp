// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/planning/seats.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace panoptic {
namespace {

constexpr double kStep_m = 0.02;
constexpr auto kThing = static_cast<PanopticId>(100);

// Boxes whose six faces are points, turned about the vertical.
class Model {
 public:
  explicit Model(double yaw = 0) : turn_(Eigen::AngleAxisd(yaw, Vec3d::UnitZ()).toRotationMatrix()) {}

  Model& box(const Vec3d& low, const Vec3d& high) {
    for (int axis = 0; axis < 3; ++axis) {
      const int u = (axis + 1) % 3;
      const int v = (axis + 2) % 3;
      for (double a = low[u] + kStep_m / 2; a < high[u]; a += kStep_m) {
        for (double b = low[v] + kStep_m / 2; b < high[v]; b += kStep_m) {
          for (const double side : {-1.0, 1.0}) {
            Vec3d at = Vec3d::Zero();
            at[u] = a;
            at[v] = b;
            at[axis] = side < 0 ? low[axis] : high[axis];
            Vec3d normal = Vec3d::Zero();
            normal[axis] = side;
            points.push_back({turn_ * at, turn_ * normal, kStep_m * kStep_m});
          }
        }
      }
    }
    return *this;
  }

  std::vector<LabelledPoint> points;

 private:
  Eigen::Matrix3d turn_;
};

LabelledSurface surface_with(const char* class_name, std::vector<LabelledPoint> points) {
  LabelledSurface surface;
  surface.voxel_m = 0.024;
  surface.class_of[kThing] = load_label_set("scannet20").find(std::string_view(class_name))->id;
  surface.of_object[kThing] = std::move(points);
  return surface;
}

std::vector<Seat> seats_of(const char* class_name, const Model& model, const std::vector<TableTop>& tables = {}) {
  return find_seats(surface_with(class_name, model.points), load_label_set("scannet20"), tables);
}

// A chair that faces -y before it is turned.
Model chair(double yaw, double seat_m = 0.45) {
  Model model(yaw);
  model.box({-0.22, -0.22, seat_m - 0.04}, {0.22, 0.2, seat_m}).box({-0.22, 0.2, seat_m - 0.04}, {0.22, 0.24, seat_m + 0.45});
  for (const double x : {-0.2, 0.16}) {
    model.box({x, -0.2, 0}, {x + 0.04, -0.16, seat_m - 0.04});
    model.box({x, 0.16, 0}, {x + 0.04, 0.2, seat_m - 0.04});
  }
  return model;
}

double degrees_off(const Seat& seat, double yaw) {
  const Vec3d expected(std::sin(yaw), -std::cos(yaw), 0);
  return std::acos(std::min(1.0, seat.facing.dot(expected))) * 180 / std::numbers::pi;
}

TEST(Seats, AChairFacesAwayFromItsBackHoweverItStands) {
  for (double yaw = 0; yaw < 6; yaw += 0.7) {
    const auto seats = seats_of("chair", chair(yaw));
    ASSERT_EQ(seats.size(), 1U);
    EXPECT_TRUE(seats[0].has_back);
    EXPECT_LT(degrees_off(seats[0], yaw), 5);
    EXPECT_NEAR(seats[0].height_m, 0.45, 0.01);
    EXPECT_LT(seats[0].position.head<2>().norm(), 0.05);
    EXPECT_GT(seats[0].normal.z(), 0.98);
    EXPECT_EQ(seats[0].object, kThing);
  }
}

TEST(Seats, ArmRestsAreNotTakenForTheBack) {
  Model model = chair(1.1);
  model.box({-0.28, -0.2, 0.6}, {-0.22, 0.2, 0.66});  // one alone, so that nothing makes up for it
  const auto seats = seats_of("chair", model);
  ASSERT_EQ(seats.size(), 1U);
  EXPECT_LT(degrees_off(seats[0], 1.1), 5);
}

TEST(Seats, ASofaHasAsManyPlacesAsPeopleFit) {
  for (const auto& [width_m, places] : {std::pair{1.0, 1}, {1.2, 2}, {1.8, 3}}) {
    Model model(0.4);
    model.box({-width_m / 2, -0.4, 0.2}, {width_m / 2, 0.3, 0.42}).box({-width_m / 2, 0.3, 0.2}, {width_m / 2, 0.45, 0.85});
    for (const double side : {-1.0, 1.0}) {
      const double x = side * (width_m / 2 + 0.08);
      model.box({x - 0.08, -0.4, 0.1}, {x + 0.08, 0.45, 0.6});
    }
    const auto seats = seats_of("sofa", model);
    ASSERT_EQ(seats.size(), static_cast<std::size_t>(places)) << width_m;
    for (const Seat& seat : seats) EXPECT_LT(degrees_off(seat, 0.4), 5);
    if (places > 1) {
      EXPECT_NEAR((seats[0].position - seats[1].position).norm(), width_m / places, 0.03);
    }
  }
}

TEST(Seats, AStoolFacesTheTableBesideIt) {
  Model stool;
  stool.box({-0.18, -0.18, 0.4}, {0.18, 0.18, 0.45});
  TableTop table;
  table.polygon = {{0.3, -0.4, 0.7}, {1.1, -0.4, 0.7}, {1.1, 0.4, 0.7}, {0.3, 0.4, 0.7}};
  const auto seats = seats_of("chair", stool, {table});
  ASSERT_EQ(seats.size(), 1U);
  EXPECT_FALSE(seats[0].has_back);
  EXPECT_LT((seats[0].facing - Vec3d::UnitX()).norm(), 0.05);
}

TEST(Seats, WhatIsTooHighOrNoSeatHasNone) {
  EXPECT_TRUE(seats_of("chair", chair(0, 0.8)).empty());
  EXPECT_TRUE(seats_of("cabinet", chair(0)).empty());
  EXPECT_TRUE(seats_of("chair", Model()).empty());
}

TEST(LyingPlaces, ABedIsOneAndItsHeadIsAtTheBoard) {
  Model bed(0.8);
  bed.box({-0.7, -1, 0.1}, {0.7, 1, 0.5}).box({-0.7, 1, 0}, {0.7, 1.06, 1});
  const auto places = find_lying_places(surface_with("bed", bed.points), load_label_set("scannet20"));
  ASSERT_EQ(places.size(), 1U);
  EXPECT_NEAR(places[0].length_m, 2, 0.06);
  EXPECT_NEAR(places[0].width_m, 1.4, 0.06);
  EXPECT_NEAR(places[0].height_m, 0.5, 0.01);
  EXPECT_GT(places[0].axis.dot(Vec3d(-std::sin(0.8), std::cos(0.8), 0)), 0.99);
  Model stool;
  stool.box({-0.3, -0.3, 0.1}, {0.3, 0.3, 0.5});
  EXPECT_TRUE(find_lying_places(surface_with("bed", stool.points), load_label_set("scannet20")).empty());
}

}  // namespace
}  // namespace panoptic
