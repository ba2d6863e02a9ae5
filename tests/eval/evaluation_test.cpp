// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Maps and predictions against scans: how labels get to the vertices, how scenes add up, and what is refused.
#include "panoptic/evaluation.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ctime>

#include "panoptic/base/json.h"
#include "panoptic/eval/labelled_vertices.h"
#include "panoptic/eval/panoptic_quality.h"
#include "panoptic/eval/scores_text.h"
#include "panoptic/eval/vertex_labels.h"
#include "panoptic/io/category_map.h"
#include "panoptic/outputs.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/io/run_json.h"
#include "tests/sanitized.h"

namespace panoptic {
namespace {

using test::error_of;
using test::fresh_folder;
using testing::ElementsAre;
using testing::HasSubstr;
namespace fs = std::filesystem;

constexpr ClassId kWall{1};
constexpr ClassId kChair{5};
constexpr ClassId kSofa{6};

// A wall and two chairs as grids of vertices, 1 cm apart, in one plane.
ScanTruth three_patches(std::uint32_t side = 20) {
  ScanTruth truth;
  truth.scene = "scene0000_00";
  for (std::uint32_t patch = 0; patch < 3; ++patch) {
    const auto base = static_cast<std::uint32_t>(truth.positions.size());
    for (std::uint32_t y = 0; y < side; ++y) {
      for (std::uint32_t x = 0; x < side; ++x) {
        truth.positions.emplace_back(4 * static_cast<float>(patch) + 0.01F * static_cast<float>(x), 0.01F * static_cast<float>(y),
                                     0);
        truth.class_id.push_back(patch == 0 ? kWall : kChair);
        truth.instance.push_back(static_cast<std::uint16_t>(patch));
        if (x + 1 < side && y + 1 < side)
          truth.triangles.push_back({base + y * side + x, base + y * side + x + 1, base + (y + 1) * side + x});
      }
    }
  }
  truth.colors.resize(truth.positions.size());
  return truth;
}

// A map of the same patches in the label set "indoor", whose chair is class 4; shifted by an offset.
LabelledMap map_of(const ScanTruth& truth, const Vec3f& offset_m) {
  LabelledMap map{{}, load_label_set("indoor"), {}, 0.02};
  for (std::size_t v = 0; v < truth.positions.size(); ++v) {
    MeshVertex vertex;
    vertex.position = truth.positions[v] + offset_m;
    const bool is_wall = truth.class_id[v] == kWall;
    vertex.class_id = map.labels.find(is_wall ? "wall" : "chair")->id;
    vertex.panoptic_id =
        is_wall ? LabelSet::id_of_class(vertex.class_id) : static_cast<PanopticId>(map.labels.first_thing() + truth.instance[v]);
    map.mesh.vertices.push_back(vertex);
  }
  map.mesh.triangles = truth.triangles;
  return map;
}

TEST(Evaluation, GivesFullMarksToThePerfectMap) {
  const ScanTruth truth = three_patches();
  Evaluation evaluation;
  evaluation.add(map_of(truth, {0, 0, 0.001F}), truth);
  const Scores scores = evaluation.scores();
  EXPECT_EQ(scores.semantic->miou, 1);
  EXPECT_EQ(scores.instance->mean, (ApScores{1, 1, 1}));
  EXPECT_EQ(scores.instance->class_agnostic, (ApScores{1, 1, 1}));
  ASSERT_EQ(scores.panoptic.size(), pq_variants().size());
  EXPECT_EQ(scores.panoptic.front().variant.name, "pq-scannet20");
  for (const PanopticScores& panoptic : scores.panoptic) EXPECT_EQ(panoptic.all, (PqScores{1, 1, 1})) << panoptic.variant.name;
  EXPECT_EQ(scores.coverage.coverage(), 1);
  EXPECT_EQ(scores.surface->at[1].f_score, 1);
  EXPECT_THAT(scores.scenes, ElementsAre("scene0000_00"));
}

TEST(Evaluation, TakesNoLabelFromFartherThanTwoVoxels) {
  const ScanTruth truth = three_patches();
  Evaluation near;
  near.add(map_of(truth, {0, 0, 0.0399F}), truth);
  EXPECT_EQ(near.scores().semantic->miou, 1);
  Evaluation far;
  far.add(map_of(truth, {0, 0, 0.0401F}), truth);
  const Scores scores = far.scores();
  EXPECT_EQ(scores.coverage.coverage(), 0);
  EXPECT_EQ(scores.semantic->miou, 0);
  EXPECT_EQ(scores.semantic->classes[0].fn, 400U);
  EXPECT_EQ(scores.instance->mean, (ApScores{0, 0, 0}));
  EXPECT_EQ(scores.panoptic.front().counts[4].fn, 2U);
  EXPECT_EQ(scores.panoptic.front().counts[4].fp, 0U);
}

TEST(Evaluation, TellsReachedFromLabelled) {
  const ScanTruth truth = three_patches();
  LabelledMap map = map_of(truth, {0, 0, 0});
  for (std::size_t v = 0; v < 400; ++v) map.mesh.vertices[v].class_id = ClassId::kUnknown;
  Evaluation evaluation;
  evaluation.add(map, truth);
  EXPECT_EQ(evaluation.scores().coverage.reached, 1200U);
  EXPECT_EQ(evaluation.scores().coverage.labelled, 800U);
}

TEST(Evaluation, AccumulatesCountsOverScenesAndNotScores) {
  const ScanTruth good = three_patches(20);
  const ScanTruth bad = three_patches(30);
  Evaluation evaluation;
  evaluation.add(map_of(good, {0, 0, 0}), good);
  evaluation.add(map_of(bad, {0, 0, 1}), bad);
  const Scores scores = evaluation.scores();
  EXPECT_DOUBLE_EQ(scores.semantic->miou.value(), 400.0 / (400 + 900));
  EXPECT_DOUBLE_EQ(scores.panoptic.front().things.pq.value(), 2 / (2 + 0.5 * 2));
  EXPECT_EQ(scores.scenes.size(), 2U);
}

TEST(Evaluation, RanksInstancesByTheirConfidence) {
  const ScanTruth truth = three_patches();
  LabelledMap map = map_of(truth, {0, 0, 0});
  const std::uint16_t first = map.labels.first_thing();
  for (std::size_t v = 0; v < 400; ++v) {  // the wall is taken for a chair
    map.mesh.vertices[v].class_id = map.labels.find("chair")->id;
    map.mesh.vertices[v].panoptic_id = static_cast<PanopticId>(first);
  }
  ScanTruth floor_truth = truth;
  for (std::size_t v = 0; v < 400; ++v) floor_truth.class_id[v] = ClassId{7}, floor_truth.instance[v] = 9;  // a table
  const auto ap50 = [&](double false_one) {
    map.confidence = {{static_cast<PanopticId>(first), false_one},
                      {static_cast<PanopticId>(first + 1), 0.5},
                      {static_cast<PanopticId>(first + 2), 0.5}};
    Evaluation evaluation;
    evaluation.add(map, floor_truth);
    return evaluation.scores().instance->classes[4].ap50.value();
  };
  EXPECT_GT(ap50(0.1), ap50(0.9));
}

TEST(Evaluation, RefusesLabelsForAnotherNumberOfVertices) {
  const ScanTruth truth = three_patches();
  Evaluation evaluation;
  LabelledVertices prediction;
  prediction.labels.class_id.resize(7);
  prediction.labels.instance.resize(7);
  EXPECT_THAT(error_of([&] { evaluation.add(prediction, truth); }),
              HasSubstr("scene0000_00: labels for 7 vertices, but the ground truth has 1200"));
  EXPECT_THAT(error_of([&] { evaluation.add_instances("s", labels_of(truth), {{kChair, 1, {1200}}}); }), HasSubstr("has 1200"));
  EXPECT_TRUE(evaluation.scores().scenes.empty());
  EXPECT_THAT(error_of([] { Evaluation("best"); }), HasSubstr("'best'"));
}

TEST(Evaluation, WritesUndefinedScoresAsNullAndAllKeys) {
  const ScanTruth truth = three_patches();
  Evaluation evaluation;
  evaluation.add(map_of(truth, {0, 0, 0}), truth);
  const Json json = to_json(evaluation.scores());
  for (const char* key : {"miou", "ap", "ap50", "ap25", "coverage"}) EXPECT_EQ(json[key], 1.0) << key;
  for (const char* key : {"pq", "sq", "rq"}) EXPECT_EQ(json[key], Json({{"all", 1.0}, {"things", 1.0}, {"stuff", 1.0}})) << key;
  EXPECT_EQ(json["per_class"].size(), kBenchmarkClassCount);
  EXPECT_EQ(json["per_class"]["chair"]["id"], 5);
  EXPECT_EQ(json["per_class"]["chair"]["ap"], 1.0);
  EXPECT_TRUE(json["per_class"]["sofa"]["iou"].is_null());
  EXPECT_TRUE(json["per_class"]["wall"]["ap"].is_null());
  EXPECT_EQ(json["pq_variants"].size(), 4U);
  const Json empty = to_json(Evaluation().scores());
  EXPECT_TRUE(empty["coverage"].is_null());
  EXPECT_FALSE(empty.contains("miou"));
}

TEST(Evaluation, OfThreeHundredThousandVerticesTakesLessThanTwoSeconds) {
  if (test::kSanitized) GTEST_SKIP() << "sanitizers are slower";
  const ScanTruth truth = three_patches(317);
  const LabelledMap map = map_of(truth, {0, 0, 0.01F});
  const std::clock_t start = std::clock();  // of the processor: others may be busy on this machine
  Evaluation evaluation;
  evaluation.add(map, truth);
  EXPECT_EQ(evaluation.scores().semantic->miou, 1);
  EXPECT_LT(std::clock() - start, 2 * CLOCKS_PER_SEC);
}

TEST(MapClasses, OfEveryBuiltInLabelSetHaveANyu40Class) {
  for (const char* name : {"indoor", "home", "scannet20"})
    EXPECT_THAT(foreign_classes(load_label_set(name)), ElementsAre()) << name;
  const LabelSet scannet20 = load_label_set("scannet20");
  for (const LabelClass& c : scannet20.classes()) EXPECT_EQ(nyu40_of_class_name(c.name), c.id) << c.name;
  EXPECT_EQ(nyu40_of_class_name("couch"), kSofa);
  EXPECT_EQ(nyu40_of_class_name("tv"), ClassId{39});
  EXPECT_EQ(nyu40_of_class_name("ceiling"), ClassId{22});
  EXPECT_EQ(nyu40_of_class_name("dragon"), std::nullopt);
  EXPECT_THAT(foreign_classes(LabelSet("zoo", {{ClassId{3}, "dragon", true, {}}})), ElementsAre(HasSubstr("class 'dragon'")));
}

TEST(MapClasses, MakeNoMaskOfARegionWithoutIdentity) {
  const ScanTruth truth = three_patches();
  LabelledMap map = map_of(truth, {0, 0, 0});
  map.labels = load_label_set("home");
  for (MeshVertex& vertex : map.mesh.vertices) {
    vertex.class_id = map.labels.find("cabinet")->id;
    vertex.panoptic_id = LabelSet::id_of_class(vertex.class_id);
  }
  const LabelledVertices carried = carry_labels(map, truth.positions);
  EXPECT_EQ(carried.labels.class_id[5], ClassId{3});
  EXPECT_THAT(instance_masks(carried), ElementsAre());
}

// A run's folder with the parts that an evaluation reads.
fs::path run_folder(const Json& report) {
  fs::path folder = fresh_folder("out");
  write_ply(folder / "mesh.ply", map_of(three_patches(), {0, 0, 0}).mesh);
  write_json_file(folder / "report.json", report);
  write_json_file(folder / "objects.json", {{"objects", {test::object_json(41, "swivel chair")}}});
  return folder;
}

TEST(RunFolder, GivesTheMapItsLabelsAndConfidences) {
  const LabelledMap map = read_run_folder(run_folder(test::report_json()));
  EXPECT_EQ(map.mesh.vertices.size(), 1200U);
  EXPECT_EQ(map.voxel_size_m, 0.024);
  EXPECT_EQ(map.labels.name(), "small");
  EXPECT_TRUE(map.labels.is_thing(ClassId{2}));
  EXPECT_DOUBLE_EQ(map.confidence.at(PanopticId{41}), 0.75 * 5 / 15);
}

TEST(RunFolder, WarnsOfAnIncompleteRunAndOfForeignClasses) {
  Json report = test::report_json();
  report["complete"] = false;
  std::vector<std::string> warnings;
  read_run_folder(run_folder(report), &warnings);
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("marked incomplete"), HasSubstr("class 'swivel chair'")));
}

}  // namespace
}  // namespace panoptic
