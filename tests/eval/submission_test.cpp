// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/eval/submission.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panoptic/base/files.h"
#include "panoptic/eval/labelled_vertices.h"
#include "panoptic/eval/scores_text.h"
#include "panoptic/evaluation.h"
#include "panoptic/io/scannet_scan.h"
#include "tests/eval/random_scenes.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

using test::error_of;
using test::fresh_folder;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
namespace fs = std::filesystem;

constexpr ClassId kChair{5};

// A folder with one instance prediction over four vertices.
fs::path instance_folder(const std::string& lines) {
  fs::path folder = fresh_folder("pred");
  fs::create_directories(folder / "pred_mask");
  write_file(folder / "pred_mask" / "a.txt", "1\n0\n0\n1\n");
  write_file(folder / "pred_mask" / "b.txt", "0\n-2\n9\n0");
  write_file(folder / "short.txt", "1\n1\n");
  write_file(folder / "scene0000_00.txt", lines);
  return folder;
}

std::string why_refused(const std::string& lines) {
  const fs::path folder = instance_folder(lines);
  return error_of([&] { read_instances(folder, "scene0000_00", 4); });
}

TEST(Submission, ReadsMasksInTheirOrder) {
  const auto masks = read_instances(instance_folder("pred_mask/b.txt 5.9 0.25\r\npred_mask/a.txt 3 1e-3\n\n"), "scene0000_00", 4);
  ASSERT_EQ(masks.size(), 2U);
  EXPECT_EQ(masks[0].class_id, kChair) << "labels are cut off, not rounded";
  EXPECT_EQ(masks[0].confidence, 0.25);
  EXPECT_THAT(masks[0].vertices, ElementsAre(1, 2));
  EXPECT_EQ(masks[1].confidence, 1e-3);
  EXPECT_THAT(masks[1].vertices, ElementsAre(0, 3));
}

TEST(Submission, LetsTheLaterLineForAMaskWin) {
  const auto masks = read_instances(
      instance_folder("pred_mask/a.txt 5 0.5\npred_mask/b.txt 5 0.6\n./pred_mask/../pred_mask/a.txt 7 0.9\n"), "scene0000_00", 4);
  ASSERT_EQ(masks.size(), 2U);
  EXPECT_EQ(masks[0].class_id, ClassId{7});
  EXPECT_EQ(masks[0].confidence, 0.9);
  EXPECT_EQ(masks[1].confidence, 0.6);
}

TEST(Submission, TakesAnEmptyPrediction) { EXPECT_TRUE(read_instances(instance_folder(""), "scene0000_00", 4).empty()); }

TEST(Submission, RefusesMasksOutsideTheFolder) {
  EXPECT_THAT(why_refused("/etc/passwd 5 1\n"), HasSubstr("scene0000_00.txt:1: the mask path '/etc/passwd' is absolute"));
  EXPECT_THAT(why_refused("../a.txt 5 1\n"), HasSubstr("'../a.txt' leaves the folder"));
  EXPECT_THAT(why_refused("pred_mask/../../a.txt 5 1\n"), HasSubstr("leaves the folder"));
}

TEST(Submission, RefusesLinesThatAreNone) {
  EXPECT_THAT(why_refused("pred_mask/a.txt 5 1\npred_mask/a.txt 5\n"),
              HasSubstr("scene0000_00.txt:2: expected 'mask_path label_id confidence'"));
  EXPECT_THAT(why_refused("pred_mask/a.txt  5 1\n"), HasSubstr("single spaces"));
  EXPECT_THAT(why_refused("pred_mask/a.txt 5 1 2\n"), HasSubstr("single spaces"));
  EXPECT_THAT(why_refused("pred_mask/a.txt chair 1\n"), HasSubstr("the label 'chair' is not a finite number"));
  EXPECT_THAT(why_refused("pred_mask/a.txt 5 nan\n"), HasSubstr("the confidence 'nan' is not a finite number"));
  EXPECT_THAT(why_refused("pred_mask/none.txt 5 1\n"), HasSubstr("none.txt"));
  EXPECT_THAT(why_refused("short.txt 5 1\n"), AllOf(HasSubstr("short.txt: 2 lines"), HasSubstr("ground truth has 4 vertices")));
}

TEST(Submission, RefusesNumbersThatAreNone) {
  const fs::path file = fresh_folder() / "scene.txt";
  write_file(file, "1\n2.5\n");
  EXPECT_THAT(error_of([&] { read_semantic(file); }), HasSubstr("scene.txt:2: expected a whole number, found '2.5'"));
  write_file(file, "1\n\n3\n");
  EXPECT_THAT(error_of([&] { read_panoptic(file); }), HasSubstr("scene.txt:2: expected a whole number, found ''"));
  write_file(file, "99999999999999999999\n");
  EXPECT_THAT(error_of([&] { read_panoptic(file); }), HasSubstr("scene.txt:1:"));
}

TEST(Submission, TakesIdsOutsideTheClassesAsUnknown) {
  const fs::path file = fresh_folder() / "scene.txt";
  write_file(file, "5001\r\n-5001\r\n0\r\n7\r\n70000000\r\n39000\r\n");
  const VertexLabels labels = read_panoptic(file);
  EXPECT_THAT(labels.class_id, ElementsAre(kChair, ClassId{0}, ClassId{0}, ClassId{0}, ClassId{0}, ClassId{39}));
  EXPECT_THAT(labels.instance, ElementsAre(1, 0, 0, 0, 0, 0));
  write_file(file, "5\n5\n-1\n70000\n41\n");
  EXPECT_THAT(read_semantic(file), ElementsAre(kChair, kChair, ClassId{0}, ClassId{0}, ClassId{41}));
}

TEST(Submission, FindsTheScenesOfAFolder) {
  const fs::path folder = fresh_folder("pred");
  EXPECT_THAT(error_of([&] { scenes_in(folder); }), HasSubstr("no predictions here"));
  EXPECT_THAT(error_of([&] { scenes_in(folder / "none"); }), HasSubstr("cannot read the folder"));
  for (const char* name : {"b.txt", "a.txt", "semantic_label_evaluation.txt", "semantic_instance_evaluation.txt", "notes.md"}) {
    write_file(folder / name, "");
  }
  fs::create_directories(folder / "pred_mask.txt");
  EXPECT_THAT(scenes_in(folder), ElementsAre("a", "b"));
}

TEST(Submission, FindsTheTruthInTextOrInAScan) {
  const fs::path folder = fresh_folder("gt");
  write_file(folder / "a.txt", "5001\n2000\n");
  EXPECT_EQ(read_truth(folder, "a", SubmissionForm::kInstance).class_id[0], kChair);
  write_file(folder / "semantic.txt", "5\n2\n");
  EXPECT_EQ(read_truth(folder, "semantic", SubmissionForm::kSemantic).class_id[0], kChair);
  ScanTruth scan;
  scan.scene = "b";
  scan.positions.resize(1);
  scan.colors.resize(1);
  scan.class_id = {kChair};
  scan.instance = {3};
  write_scan_truth(folder / "b", scan);
  EXPECT_EQ(read_truth(folder, "b", SubmissionForm::kPanoptic), (VertexLabels{{kChair}, {3}}));
  EXPECT_THAT(error_of([&] { read_truth(folder, "c", SubmissionForm::kInstance); }),
              HasSubstr("no ground truth for the prediction of c"));
}

// The scores of the files that were written.
Scores scores_of_files(const fs::path& folder, const std::string& scene) {
  Evaluation evaluation;
  const auto truth = [&](SubmissionForm form, const char* name) { return read_truth(folder / "truth" / name, scene, form); };
  const VertexLabels instance_truth = truth(SubmissionForm::kInstance, "instance");
  evaluation.add_semantic(scene, truth(SubmissionForm::kSemantic, "semantic"),
                          read_semantic(folder / "semantic" / (scene + ".txt")));
  evaluation.add_instances(scene, instance_truth, read_instances(folder / "instance", scene, instance_truth.class_id.size()));
  evaluation.add_panoptic(scene, truth(SubmissionForm::kPanoptic, "panoptic"),
                          read_panoptic(folder / "panoptic" / (scene + ".txt")));
  return evaluation.scores();
}

TEST(Submission, ScoresAsWhatItWasWrittenFrom) {
  std::mt19937_64 random(6);
  for (int round = 0; round < 4; ++round) {
    const VertexLabels labels = test::random_labels(random, 3000);
    ScanTruth truth;
    truth.scene = "scene0007_00";
    truth.class_id = labels.class_id;
    truth.instance.assign(labels.instance.begin(), labels.instance.end());
    LabelledVertices prediction{test::disturbed(random, labels), {}, {}};
    for (std::uint32_t i = 0; i < 40; ++i) prediction.confidence[i] = static_cast<double>(test::below(random, 1000)) / 999;
    Evaluation evaluation;
    evaluation.add(prediction, truth);
    const fs::path folder = fresh_folder(fmt::format("round{}", round));
    write_submission(folder, truth.scene, prediction, labels_of(truth));
    EXPECT_EQ(to_csv(scores_of_files(folder, truth.scene)), to_csv(evaluation.scores()));
  }
}

TEST(Submission, RefusesMoreInstancesThanItsFormHolds) {
  VertexLabels many{std::vector<ClassId>(1000, kChair), {}};
  for (std::uint32_t i = 1; i <= 1000; ++i) many.instance.push_back(i);
  EXPECT_THAT(error_of([&] {
                write_submission(fresh_folder(), "s", {many, {}, {}}, many);
              }),
              HasSubstr("more than 999 instances of class 5"));
}

TEST(ScoresText, GivesTheBenchmarksOwnHeaderToInstanceScores) {
  const VertexLabels truth{std::vector<ClassId>(200, kChair), std::vector<std::uint32_t>(200, 1)};
  Evaluation evaluation;
  evaluation.add_instances("s", truth, {});
  const std::string csv = to_csv(evaluation.scores());
  EXPECT_THAT(csv, testing::StartsWith("class,class id,ap,ap50,ap25\ncabinet,3,nan,nan,nan\nbed,4,nan,nan,nan\nchair,5,0,0,0\n"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 19);
  EXPECT_THAT(to_table(evaluation.scores()),
              AllOf(HasSubstr("chair"), HasSubstr("coverage      0.0 % of 200 annotated vertices")));
}

}  // namespace
}  // namespace panoptic
