// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/pose_list.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "panoptic/error.h"
#include "tests/fresh_folder.h"
#include "tests/io/recordings.h"

namespace panoptic::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

PoseList read_text(const std::string& text) {
  const fs::path path = fresh_folder("poses") / "poses.txt";
  write_text(path, text);
  return read_pose_list(path);
}

std::string error_of_text(const std::string& text) {
  try {
    read_text(text);
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

// The three poses that every form is written from.
std::string lines(const std::function<std::string(int)>& line) { return line(0) + line(1) + line(2); }

void expect_poses(const PoseList& list, PoseKey key = PoseKey::kNone) {
  ASSERT_EQ(list.poses.size(), 3U) << list.form;
  EXPECT_EQ(list.key, key) << list.form;
  for (int i = 0; i < 3; ++i) {
    EXPECT_LT((list.poses[static_cast<std::size_t>(i)].matrix - pose_matrix(i)).cwiseAbs().maxCoeff(), 1e-6)
        << list.form << " " << i;
  }
}

std::string numbers_of(const Eigen::MatrixXd& rows, char separator = ' ') {
  std::string text;
  for (Eigen::Index i = 0; i < rows.size(); ++i)
    text += fmt::format("{}{:.9f}", i == 0 ? "" : std::string(1, separator), rows(i / rows.cols(), i % rows.cols()));
  return text;
}

std::string position(int i) { return numbers_of(pose_matrix(i).topRightCorner<3, 1>()); }
std::string quaternion(int i, bool w_first) {
  const Eigen::Quaterniond q(Eigen::Matrix3d(pose_matrix(i).topLeftCorner<3, 3>()));
  return w_first ? fmt::format("{:.9f} {:.9f} {:.9f} {:.9f}", q.w(), q.x(), q.y(), q.z())
                 : fmt::format("{:.9f} {:.9f} {:.9f} {:.9f}", q.x(), q.y(), q.z(), q.w());
}

TEST(PoseList, ReadsMatricesAsLinesOf16And12Numbers) {
  expect_poses(read_text(lines([](int i) { return numbers_of(pose_matrix(i)) + "\n"; })));
  expect_poses(read_text(lines([](int i) { return numbers_of(pose_matrix(i).topRows<3>()) + "\n"; })));
  expect_poses(read_text(lines([](int i) { return numbers_of(pose_matrix(i), ',') + "\n"; })));
  expect_poses(read_text(lines([](int i) { return "[" + numbers_of(pose_matrix(i), ';') + "]\r\n"; })));
}

TEST(PoseList, TellsColumnsFromRowsByWhereTheRotationIs) {
  const PoseList list = read_text(lines([](int i) { return numbers_of(pose_matrix(i).transpose()) + "\n"; }));
  expect_poses(list);
  EXPECT_EQ(list.form, "4x4 matrices column by column");
  const auto rotation_first = [](int i) {
    return numbers_of(Eigen::MatrixXd(pose_matrix(i).topLeftCorner<3, 3>())) + " " + position(i) + "\n";
  };
  expect_poses(read_text(lines(rotation_first)));
}

TEST(PoseList, ReadsPositionsAndQuaternionsInEitherOrder) {
  const PoseList list = read_text(lines([](int i) { return position(i) + " " + quaternion(i, false) + "\n"; }));
  expect_poses(list);
  EXPECT_EQ(list.form, "position and quaternion, w last");
  expect_poses(read_text(lines([](int i) { return quaternion(i, true) + " " + position(i) + "\n"; })));
  expect_poses(
      read_text("# tx ty tz qw qx qy qz\n" + lines([](int i) { return position(i) + " " + quaternion(i, true) + "\n"; })));
}

TEST(PoseList, KeepsANumberOrANameThatComesFirst) {
  const auto after = [](const std::string& key, const std::string& pose) { return key + " " + pose + "\n"; };
  for (const bool full : {true, false}) {
    const auto pose = [&](int i) { return numbers_of(full ? Eigen::MatrixXd(pose_matrix(i)) : pose_matrix(i).topRows<3>()); };
    const PoseList numbered = read_text(lines([&](int i) { return after(std::to_string(7 + i), pose(i)); }));
    expect_poses(numbered, PoseKey::kNumber);
    EXPECT_EQ(numbered.poses[2].number, 9);
    const PoseList named = read_text(lines([&](int i) { return after(fmt::format("img_{}.jpg", i), pose(i)); }));
    expect_poses(named, PoseKey::kName);
    EXPECT_EQ(named.poses[1].name, "img_1.jpg");
  }
  const PoseList timed =
      read_text(lines([&](int i) { return after(fmt::format("130503{}.25", i), position(i) + " " + quaternion(i, false)); }));
  expect_poses(timed, PoseKey::kNumber);
  EXPECT_EQ(timed.poses[1].number, 1305031.25);
  const auto with_id = [&](int i) { return fmt::format("{} {} {} {}\n", 100.5 + i, position(i), quaternion(i, false), i + 1); };
  expect_poses(read_text(lines(with_id)), PoseKey::kNumber);
}

TEST(PoseList, ReadsMatricesOfOneRowALine) {
  expect_poses(read_text(lines([](int i) { return matrix_text(pose_matrix(i)) + "\n"; })));
  const auto without_last = [&](int i) {
    const std::string text = matrix_text(pose_matrix(i));
    return text.substr(0, text.find('\n', text.find('\n', text.find('\n') + 1) + 1) + 1);
  };
  expect_poses(read_text(lines(without_last)));
  const PoseList log = read_text(lines([](int i) { return fmt::format("{0} {0} 3\n", i) + matrix_text(pose_matrix(i)); }));
  expect_poses(log, PoseKey::kNumber);
  EXPECT_EQ(log.poses[2].number, 2);
}

TEST(PoseList, SkipsAByteOrderMarkAHeadingAndComments) {
  const std::string poses = lines([](int i) { return numbers_of(pose_matrix(i)) + "\n"; });
  expect_poses(read_text("\xEF\xBB\xBF" + poses));
  expect_poses(read_text("r00 r01 r02 tx r10 r11 r12 ty\n# a comment\n" + poses));
}

TEST(PoseList, ReadsDecimalCommas) {
  std::string text = lines([](int i) { return numbers_of(pose_matrix(i).topRows<3>()) + " 0 0 0 1\n"; });  // as %g prints them
  std::replace(text.begin(), text.end(), '.', ',');
  expect_poses(read_text(text));
}

TEST(PoseList, KeepsLostPosesAsTheyAre) {
  const PoseList list =
      read_text(numbers_of(pose_matrix(0)) + "\n" + "nan nan nan nan nan nan nan nan nan nan nan nan nan nan nan nan\n");
  ASSERT_EQ(list.poses.size(), 2U);
  EXPECT_FALSE(list.poses[1].matrix.allFinite());
}

TEST(PoseList, NamesTheLineThatIsNoPose) {
  const std::string pose = numbers_of(pose_matrix(0)) + "\n";
  EXPECT_THAT(error_of_text(pose + "1 2 3\n"), HasSubstr("poses.txt:2: 3 numbers, but 16 in line 1"));
  EXPECT_THAT(error_of_text("1 2 3 4 5\n"), HasSubstr("poses.txt:1: 5 numbers, expected the 16 of a 4x4 matrix"));
  EXPECT_THAT(error_of_text("1 2 3 0.1 0.2 0.3\n"), HasSubstr("angles are not read"));
  EXPECT_THAT(error_of_text(pose + "1 0 0 zero 0 1 0 0 0 0 1 0 0 0 0 1\n"),
              HasSubstr("poses.txt:2: expected a number, found 'zero'"));
  EXPECT_THAT(error_of_text("1 0 0 0\n0 1 0 0\n"), HasSubstr("2 rows of 4 numbers"));
  EXPECT_THAT(error_of_text("0 0 1\n" + matrix_text(pose_matrix(0)) + "1 1 2\n"), HasSubstr("poses.txt:6: expected one matrix"));
}

TEST(PoseList, EveryTruncationIsAnErrorOrFewerPoses) {
  const std::string text = lines([](int i) { return fmt::format("{0} {0} 3\n", i) + matrix_text(pose_matrix(i)); });
  for (std::size_t bytes = 0; bytes < text.size(); ++bytes) {
    const fs::path path = fresh_folder("poses") / "poses.txt";
    write_text(path, text.substr(0, bytes));
    try {
      EXPECT_LE(read_pose_list(path).poses.size(), 3U);
    } catch (const Error& e) {
      EXPECT_THAT(e.what(), HasSubstr("poses.txt:"));
    }
  }
}

}  // namespace
}  // namespace panoptic::test
