// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Poses without names beside images that text and numbers put in different orders: a walk through a room, written out as users
// have it.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/fresh_folder.h"
#include "tests/io/box_room.h"
#include "tests/io/recordings.h"

namespace panoptic::test {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr std::size_t kImages = 24;

// images/0.png to images/23.png; every one of `room`'s steps is far enough to be seen.
fs::path write_room(const BoxRoom& room) {
  const fs::path root = fresh_folder("unpadded");
  for (std::size_t i = 0; i < room.size(); ++i) {
    const Frame frame = *room.read(i).frame;
    Image<std::uint16_t> millimetres(frame.depth.width(), frame.depth.height());
    for (std::size_t p = 0; p < millimetres.size(); ++p)
      millimetres[p] = static_cast<std::uint16_t>(std::lround(1000.0F * frame.depth[p]));
    write_depth(root / fmt::format("depth/{}.png", i), millimetres);
    write_color(root / fmt::format("images/{}.png", i), Image<Rgb>(frame.depth.width(), frame.depth.height()));
  }
  write_text(root / "K.txt", intrinsic_text(room.camera));
  return root;
}

std::vector<std::size_t> numeric_order() {
  std::vector<std::size_t> order(kImages);
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  return order;
}

std::vector<std::size_t> text_order() {
  std::vector<std::size_t> order = numeric_order();
  std::sort(order.begin(), order.end(), [](auto a, auto b) { return std::to_string(a) < std::to_string(b); });
  return order;
}

void write_poses(const fs::path& root, const std::vector<Pose>& poses, const std::vector<std::size_t>& order) {
  std::string text;
  for (const std::size_t i : order) text += matrix_text(poses[i].matrix(), " ") + "\n";
  write_text(root / "poses.txt", text);
}

void expect_poses(const Dataset& dataset, const std::vector<Pose>& poses) {
  for (std::size_t i = 0; i < poses.size(); ++i) EXPECT_TRUE(dataset.pose(i)->isApprox(poses[i], 1e-6)) << i;
}

TEST(PoseOrder, IsTheOneWhosePosesAgreeWithTheDepth) {
  const BoxRoom room = walk_through_a_room(kImages);
  const fs::path root = write_room(room);
  write_poses(root, room.way, text_order());
  const auto by_text = open_recording(root);
  expect_poses(*by_text, room.way);
  EXPECT_THAT(by_text->notes().assumed,
              Contains(HasSubstr("poses.txt: its poses are in the order of the images' names as text (1, 10, 2), not of their "
                                 "numbers (1, 2, 10): neighbouring depth images then agree on")));
  write_poses(root, room.way, numeric_order());
  const auto by_number = open_recording(root);
  expect_poses(*by_number, room.way);
  EXPECT_THAT(by_number->notes().assumed, Contains(HasSubstr("in the order of the images' numbers (1, 2, 10), not of")));
}

TEST(PoseOrder, IsTheOneOfTheShorterWayWhereTheDepthScaleIsWrongToo) {
  BoxRoom room = walk_through_a_room(kImages);
  room.depth_factor = 0.2;
  const fs::path root = write_room(room);
  write_poses(root, room.way, text_order());
  const auto dataset = open_recording(root);
  expect_poses(*dataset, room.way);
  EXPECT_THAT(dataset->notes().assumed, Contains(HasSubstr("the camera then moves")));
}

TEST(PoseOrder, IsRefusedWhereNeitherFits) {
  const BoxRoom room = walk_through_a_room(kImages);
  const fs::path root = write_room(room);
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < kImages; ++i) order.push_back(7 * i % kImages);
  write_poses(root, room.way, order);
  EXPECT_THAT(error_of(root), HasSubstr("poses.txt: is line 3 of the image numbered 2 (1, 2, 10) or of the third name as text"));
  EXPECT_THAT(error_of(root), HasSubstr("write the image's name before each pose"));
}

TEST(PoseOrder, IsNoQuestionWhereAllPosesAreTheSameOrNamesArePadded) {
  BoxRoom room = walk_through_a_room(kImages);
  const fs::path root = write_room(room);
  write_poses(root, std::vector<Pose>(kImages, room.way.front()), numeric_order());
  EXPECT_THAT(open_recording(root)->notes().assumed, Not(Contains(HasSubstr("(1, 10, 2)"))));
  for (std::size_t i = 0; i < 10; ++i) {
    for (const char* folder : {"images", "depth"})
      fs::rename(root / folder / fmt::format("{}.png", i), root / folder / fmt::format("{:02}.png", i));
  }
  write_poses(root, room.way, numeric_order());
  expect_poses(*open_recording(root), room.way);
  EXPECT_THAT(open_recording(root)->notes().assumed, Not(Contains(HasSubstr("(1, 10, 2)"))));
}

}  // namespace
}  // namespace panoptic::test
