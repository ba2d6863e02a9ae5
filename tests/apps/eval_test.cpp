// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// `panoptic eval` from outside.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "panoptic/base/files.h"
#include "panoptic/base/json.h"
#include "panoptic/io/scannet_scan.h"
#include "panoptic/outputs.h"
#include "tests/apps/program.h"
#include "tests/fresh_folder.h"
#include "tests/io/run_json.h"
#include "tests/shared_data.h"

namespace panoptic {
namespace {

using test::fresh_folder;
using test::object_json;
using test::ProgramResult;
using test::report_json;
using test::run_program;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;
namespace fs = std::filesystem;

constexpr const char* kVectors = "specs/eval_vectors.json";

std::string run_lines(const Json& runs) {
  std::string text;
  for (const Json& run : runs) {
    for (std::size_t i = 0; i < run[1].get<std::size_t>(); ++i) text += fmt::format("{}\n", run[0].get<int>());
  }
  return text;
}

// One scene in the benchmark's instance form.
void write_instance_scene(const Json& scene, const std::string& name, const fs::path& pred, const fs::path& gt) {
  const std::string truth = run_lines(scene["gt_runs"]);
  write_file(gt / (name + ".txt"), truth);
  const auto vertices = std::count(truth.begin(), truth.end(), '\n');
  std::string list;
  fs::create_directories(pred / "pred_mask");
  for (const Json& p : scene["preds"]) {
    std::string mask;
    for (long v = 0; v < vertices; ++v) mask += v >= p["begin"].get<long>() && v < p["end"].get<long>() ? "1\n" : "0\n";
    const std::string file = fmt::format("pred_mask/{}_{}.txt", name, std::count(list.begin(), list.end(), '\n'));
    write_file(pred / file, mask);
    list += fmt::format("{} {} {}\n", file, p["label"].get<int>(), p["conf"].get<double>());
  }
  write_file(pred / (name + ".txt"), list);
}

struct Folders {
  fs::path pred = fresh_folder("pred");
  fs::path gt = fresh_folder("gt");
  fs::path json = fresh_folder("scores") / "scores.json";
};

ProgramResult eval(const std::string& form, const Folders& f, const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments = {"eval", form,          "--pred", f.pred.string(),
                                        "--gt", f.gt.string(), "--json", f.json.string()};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_program(arguments);
}

TEST(Eval, GivesTheInstanceVectorsOfThePublicEvaluator) {
  PANOPTIC_REQUIRE_SHARED(kVectors);
  const Json vectors = read_json_file(test::shared_folder() / kVectors);
  for (const auto& [name, vector] : vectors["scannet_instance"].items()) {
    const Folders f;
    std::size_t count = 0;
    for (const Json& scene : vector["scenes"]) write_instance_scene(scene, fmt::format("scene{:04}_00", count++), f.pred, f.gt);
    const ProgramResult result = eval("instance", f, {"--csv", (f.json.parent_path() / "s.csv").string()});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const Json scores = read_json_file(f.json);
    EXPECT_NEAR(scores["ap"].get<double>(), vector["mean_ap_ap50_ap25"][0].get<double>(), 1e-9) << name;
    EXPECT_NEAR(scores["ap50"].get<double>(), vector["mean_ap_ap50_ap25"][1].get<double>(), 1e-9) << name;
    EXPECT_NEAR(scores["ap25"].get<double>(), vector["mean_ap_ap50_ap25"][2].get<double>(), 1e-9) << name;
    EXPECT_THAT(read_file(f.json.parent_path() / "s.csv"), StartsWith("class,class id,ap,ap50,ap25\n"));
  }
}

TEST(Eval, GivesTheSemanticVectorOfThePublicEvaluator) {
  PANOPTIC_REQUIRE_SHARED(kVectors);
  const Json vector = read_json_file(test::shared_folder() / kVectors)["scannet_semantic"]["S1"];
  const Folders f;
  write_file(f.gt / "scene0000_00.txt", run_lines(vector["gt_runs"]));
  write_file(f.pred / "scene0000_00.txt", run_lines(vector["pred_runs"]));
  ASSERT_EQ(eval("semantic", f).exit_code, 0);
  const Json scores = read_json_file(f.json);
  EXPECT_NEAR(scores["miou"].get<double>(), vector["mean_over_defined"].get<double>(), 1e-9);
  EXPECT_NEAR(scores["per_class"]["floor"]["iou"].get<double>(), 0.72, 1e-9);
  EXPECT_TRUE(scores["per_class"]["sofa"]["iou"].is_null());
}

TEST(Eval, CountsPanopticQualityByTheVariantAskedFor) {
  const Folders f;
  std::string truth;
  std::string prediction;
  for (int i = 0; i < 300; ++i) truth += i < 150 ? "1000\n" : i < 200 ? "5001\n" : "7001\n";
  for (int i = 0; i < 300; ++i) prediction += i < 150 ? "1000\n" : i < 200 ? "0\n" : "7004\n";
  write_file(f.gt / "scene0000_00.txt", truth);
  write_file(f.pred / "scene0000_00.txt", prediction);
  ASSERT_EQ(eval("panoptic", f).exit_code, 0);
  EXPECT_EQ(read_json_file(f.json)["pq"], Json({{"all", 1.0}, {"things", 1.0}, {"stuff", 1.0}})) << "the small chair is void";
  ASSERT_EQ(eval("panoptic", f, {"--variant", "seed"}).exit_code, 0);
  const Json seed = read_json_file(f.json);
  EXPECT_EQ(seed["pq"]["things"], 0.5);
  EXPECT_EQ(seed["pq_variants"]["pq-scannet20"]["pq"]["things"], 1.0);
  EXPECT_EQ(seed["rules"]["min_true_thing_vertices"], 0);
}

// A wall of 400 vertices and a chair of 400: the truth, and a run that mapped both a little off.
fs::path write_scan_and_run(const fs::path& scan) {
  fs::path out = fresh_folder("out");
  ScanTruth truth;
  truth.scene = "scene0003_00";
  Mesh mesh;
  for (int i = 0; i < 800; ++i) {
    const bool is_wall = i < 400;
    truth.positions.emplace_back(0.01F * static_cast<float>(i % 20), 0.01F * static_cast<float>(i / 20), is_wall ? 0.0F : 1.0F);
    truth.class_id.push_back(ClassId{static_cast<std::uint16_t>(is_wall ? 1 : 5)});
    truth.instance.push_back(is_wall ? 0 : 1);
    mesh.vertices.push_back({truth.positions.back() + Vec3f(0, 0, 0.004F),
                             {0, 0, 1},
                             {},
                             ClassId{static_cast<std::uint16_t>(is_wall ? 1 : 4)},
                             PanopticId{is_wall ? 1U : 40U}});
    if (i % 20 != 19 && i / 20 % 20 != 19)
      truth.triangles.push_back({std::uint32_t(i), std::uint32_t(i + 1), std::uint32_t(i + 20)});
  }
  truth.colors.resize(800);
  mesh.triangles = truth.triangles;
  write_scan_truth(scan, truth);
  write_ply(out / "mesh.ply", mesh);
  Json object = object_json(40, "chair");
  object["probabilities"] = {{"chair", 0.9}};
  object["observations"] = 10;
  write_json_file(out / "objects.json", {{"objects", {object}}});
  Json report = report_json();
  report["labels"] = Json::parse(R"([{"id": 1, "name": "wall", "is_thing": false, "color": [0, 0, 0]},
      {"id": 4, "name": "chair", "is_thing": true, "color": [0, 0, 0]},
      {"id": 39, "name": "orange", "is_thing": true, "color": [0, 0, 0]}])");
  write_json_file(out / "report.json", report);
  return out;
}

TEST(Eval, ScoresARunAndWritesASubmissionThatScoresTheSame) {
  const fs::path scan = fresh_folder("scan");
  const fs::path out = write_scan_and_run(scan);
  const fs::path submission = fresh_folder("submission");
  const fs::path json = out / "scores.json";
  const ProgramResult result = run_program(
      {"eval", out.string(), "--gt", scan.string(), "--json", json.string(), "--write-submission", submission.string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_THAT(result.out,
              AllOf(HasSubstr("coverage      100.0 %"), HasSubstr("pq-scannet20"), HasSubstr("ndt"), HasSubstr("F-score 100.0")));
  const Json scores = read_json_file(json);
  for (const char* key : {"miou", "ap", "ap50", "ap25", "coverage"}) EXPECT_EQ(scores[key], 1.0) << key;
  EXPECT_EQ(scores["pq"]["all"], 1.0);
  EXPECT_NEAR(scores["surface"]["accuracy_m"].get<double>(), 0.004, 0.002);
  EXPECT_EQ(read_file(submission / "instance" / "scene0003_00.txt"), "pred_mask/scene0003_00_000.txt 5 0.45\n");
  for (const char* form : {"semantic", "instance", "panoptic"}) {
    const ProgramResult again = run_program({"eval", form, "--pred", (submission / form).string(), "--gt",
                                             (submission / "truth" / form).string(), "--json", json.string()});
    ASSERT_EQ(again.exit_code, 0) << again.err;
    const Json part = read_json_file(json);
    for (const char* key : {"miou", "ap", "ap50", "ap25", "pq", "sq", "rq"}) {
      if (part.contains(key)) {
        EXPECT_EQ(part[key], scores[key]) << form << " " << key;
      }
    }
  }
}

TEST(Eval, SaysInOneLineWhatIsWrongWithItsInput) {
  const Folders f;
  const auto why = [&](const std::string& form) {
    const ProgramResult result = eval(form, f);
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_EQ(test::lines(result.err).size(), 1U) << result.err;
    EXPECT_FALSE(fs::exists(f.json));
    return result.err;
  };
  EXPECT_THAT(why("semantic"), HasSubstr("no predictions here"));
  write_file(f.pred / "scene0000_00.txt", "1\n2\n");
  EXPECT_THAT(why("semantic"), HasSubstr("no ground truth for the prediction of scene0000_00"));
  write_file(f.gt / "scene0000_00.txt", "1\n2\n0\n");
  EXPECT_THAT(why("semantic"), HasSubstr("scene0000_00: labels for 2 vertices, but the ground truth has 3"));
  EXPECT_THAT(why("panoptic"), HasSubstr("gt/scene0000_00.txt: 2 of 2 labels are below 1000"));
  write_file(f.gt / "scene0000_00.txt", "1000\n2000\n0\n");
  EXPECT_THAT(why("semantic"), HasSubstr("gt/scene0000_00.txt: 2 of 2 labels are no class, 1000 for one"));
  EXPECT_THAT(why("panoptic"), HasSubstr("pred/scene0000_00.txt: 2 of 2 labels are below 1000"));
  EXPECT_THAT(why("instance"), HasSubstr("expected 'mask_path label_id confidence'"));
  write_file(f.pred / "scene0000_00.txt", "1000\n2000\n");
  EXPECT_THAT(why("panoptic"), HasSubstr("labels for 2 vertices"));
  write_file(f.pred / "scene0000_00.txt", "1\nchair\n2\n");
  write_file(f.gt / "scene0000_00.txt", "1\n2\n0\n");
  EXPECT_THAT(why("semantic"), HasSubstr("scene0000_00.txt:2: expected a whole number, found 'chair'"));
}

TEST(Eval, ScoresAnEmptyPredictionAsNothingFound) {
  const Folders f;
  std::string truth;
  for (int i = 0; i < 200; ++i) truth += "5001\n";
  write_file(f.gt / "scene0000_00.txt", truth);
  write_file(f.gt / "scene0001_00.txt", truth);
  write_file(f.pred / "scene0000_00.txt", "");
  const ProgramResult result = eval("instance", f);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("warning: 1 scenes of"));
  const Json scores = read_json_file(f.json);
  EXPECT_EQ(scores["ap"], 0.0);
  EXPECT_EQ(scores["coverage"], 0.0);
  EXPECT_TRUE(scores["per_class"]["table"]["ap"].is_null());
}

TEST(Eval, RefusesArgumentsThatContradict) {
  const auto why = [](const std::vector<std::string>& arguments) {
    const ProgramResult result = run_program(arguments);
    EXPECT_EQ(result.exit_code, 2) << result.err;
    return result.err;
  };
  EXPECT_THAT(why({"eval", "semantic", "--gt", "gt"}), HasSubstr("eval semantic needs --pred DIR"));
  EXPECT_THAT(why({"eval", "out", "--gt", "gt", "--pred", "p"}), HasSubstr("--pred goes with"));
  EXPECT_THAT(why({"eval", "panoptic", "--gt", "gt", "--pred", "p", "--write-submission", "s"}),
              HasSubstr("--write-submission takes a run"));
  EXPECT_THAT(why({"eval", "out"}), HasSubstr("--gt"));
  EXPECT_EQ(run_program({"eval", "out", "--gt", "gt", "--variant", "best"}).exit_code, 1);
}

}  // namespace
}  // namespace panoptic
