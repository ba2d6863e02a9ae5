// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/run_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panoptic/base/files.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/io/run_json.h"

namespace panoptic {
namespace {

using test::error_of;
using test::object_json;
using test::report_json;
using testing::AllOf;
using testing::HasSubstr;
namespace fs = std::filesystem;

class RunFiles : public testing::Test {
 protected:
  std::string report_refusal(const Json& report) const {
    write_json_file(folder_ / "report.json", report);
    return error_of([&] { read_run_report(folder_); });
  }
  std::string objects_refusal(const Json& objects) const {
    write_json_file(folder_ / "objects.json", objects);
    return error_of([&] { read_run_objects(folder_); });
  }
  std::string object_refusal(const char* key, const Json& value) const {
    Json object = object_json(31, "swivel chair");
    object[key] = value;
    return objects_refusal({{"objects", {object}}});
  }

  fs::path folder_ = test::fresh_folder("run");
};

TEST_F(RunFiles, AreReadAsTheyWereWritten) {
  write_json_file(folder_ / "report.json", report_json());
  const RunReport report = read_run_report(folder_);
  EXPECT_EQ(report.recording, "sim:7");
  EXPECT_EQ(report.calibration, "");
  EXPECT_EQ(report.without_prediction, 4U);
  EXPECT_EQ(report.stages.at("fusion").p95_ms, 5);
  EXPECT_EQ(report.labels.name(), "small");
  EXPECT_EQ(report.labels.find("swivel chair")->color, (Rgb{31, 119, 180}));
  EXPECT_EQ(report.voxel_size_m, 0.024);
  write_json_file(folder_ / "objects.json", {{"objects", {object_json(31, "swivel chair")}}, {"merged_into", {{"33", 31}}}});
  const RunObjects objects = read_run_objects(folder_);
  ASSERT_EQ(objects.objects.size(), 1U);
  const RunObject& object = objects.objects[0];
  EXPECT_EQ(object.probabilities.front(), (std::pair<std::string, double>("swivel chair", 0.75)));
  EXPECT_EQ(object.votes.at(0).of_class.front(), (std::pair<std::string, std::uint64_t>("swivel chair", 4)));
  EXPECT_EQ(object.best_views.at(0).box, (PixelBox{10, 20, 50, 60}));
  EXPECT_EQ(object.history.size(), 1U);
  EXPECT_EQ(objects.merged_into.at(PanopticId{33}), PanopticId{31});
}

TEST_F(RunFiles, EachThatIsMissingIsNamedInTheSameWords) {
  const auto missing = [&](const char* name) {
    return folder_.string() + ": no " + name + " in it; name the folder that panoptic run wrote";
  };
  EXPECT_EQ(error_of([&] { read_run_report(folder_); }), missing("report.json"));
  EXPECT_EQ(error_of([&] { read_run_objects(folder_); }), missing("objects.json"));
  EXPECT_EQ(error_of([&] { read_run_mesh(folder_); }), missing("mesh.ply"));
  EXPECT_TRUE(read_run_path(folder_).empty()) << "early versions wrote none";
}

TEST_F(RunFiles, EveryMissingOrWrongValueOfAReportIsNamed) {
  const Json good = report_json();
  for (const auto& [key, value] : good.items()) {
    for (const Json& wrong : {Json(nullptr), Json("text"), Json(-1), Json::array({1, "a"})}) {
      const bool is_text = value.is_string() || value.is_null();
      if (is_text && (wrong.is_string() || wrong.is_null())) continue;
      Json report = good;
      report[key] = wrong;
      EXPECT_THAT(report_refusal(report), AllOf(HasSubstr("report.json"), HasSubstr(key))) << key << " " << wrong;
    }
  }
  Json twice = report_json();
  twice["labels"][1]["id"] = 1;
  EXPECT_THAT(report_refusal(twice), HasSubstr("report.json: labels must be classes that go together"));
  Json small = report_json();
  small["options"]["map"]["voxel_size_m"] = -1;
  EXPECT_THAT(report_refusal(small), HasSubstr("options.map.voxel_size_m must be"));
  EXPECT_THAT(report_refusal(Json::array({1})), HasSubstr("report.json: the whole must be an object"));
}

TEST_F(RunFiles, EveryMissingOrWrongValueOfAnObjectIsNamed) {
  const Json good = object_json(31, "swivel chair");
  for (const auto& [key, value] : good.items()) {
    EXPECT_THAT(object_refusal(key.c_str(), nullptr), AllOf(HasSubstr("objects.json: objects[0]"), HasSubstr(key)));
  }
  EXPECT_THAT(object_refusal("id", -1), HasSubstr("objects[0].id must be"));
  EXPECT_THAT(object_refusal("id", 4294967296), HasSubstr("objects[0].id must be"));
  EXPECT_THAT(object_refusal("class", 7), HasSubstr("objects[0].class must be"));
  EXPECT_THAT(object_refusal("probabilities", {{"swivel chair", 2}}), HasSubstr("probabilities.swivel chair must be"));
  EXPECT_THAT(object_refusal("box", {{"min_m", {0, 0}}, {"max_m", {1, 2, 3}}}), HasSubstr("box.min_m must be three numbers"));
  EXPECT_THAT(object_refusal("votes", {{"frames_per_bin", 0}}), HasSubstr("votes.frames_per_bin must be"));
  Json view = good["best_views"];
  view[0]["box_px"] = {50, 20, 10, 60};
  EXPECT_THAT(object_refusal("best_views", view), HasSubstr("box_px must be a box that is not empty"));
  view[0]["box_px"] = {0, 0, 1, 1e12};
  EXPECT_THAT(object_refusal("best_views", view), HasSubstr("best_views[0].box_px[3] must be"));
  EXPECT_THAT(objects_refusal(Json::object()), HasSubstr("\"objects\""));
  EXPECT_THAT(objects_refusal({{"objects", Json::object()}}), HasSubstr("objects must be an array"));
  for (const char* key : {"x33", "", "33x", "99999999999"}) {
    EXPECT_THAT(objects_refusal({{"objects", Json::array()}, {"merged_into", {{key, 31}}}}),
                HasSubstr("merged_into must be an object whose keys are ids"));
  }
}

TEST_F(RunFiles, APathThatIsNoneIsRefusedWithItsLine) {
  write_file(folder_ / "trajectory.txt", "# time x y z qx qy qz qw\n0.5 1 2 3 0 0 0 1\n\n1.5 4 5 6 0 0 0 1\n");
  EXPECT_EQ(read_run_path(folder_), (std::vector<Vec3d>{Vec3d(1, 2, 3), Vec3d(4, 5, 6)}));
  for (const char* wrong : {"0 1 2 3\n", "0 a b c 0 0 0 1\n", "0 nan 0 0 0 0 0 1\n", "0 1e30 0 0 0 0 0 1\n"}) {
    write_file(folder_ / "trajectory.txt", std::string("0 0 0 0 0 0 0 1\n") + wrong);
    EXPECT_THAT(error_of([&] { read_run_path(folder_); }), HasSubstr("trajectory.txt:2: expected"));
  }
}

}  // namespace
}  // namespace panoptic
