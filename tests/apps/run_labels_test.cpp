// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// `panoptic run` and where its labels come from: flags, options, predictions, label sets.
#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/outputs.h"
#include "tests/apps/run_fixture.h"

namespace panoptic {
namespace {

using test::expect_one_line;
using test::fresh_folder;
using test::ProgramResult;
using test::Run;
using testing::HasSubstr;
namespace fs = std::filesystem;

TEST_F(Run, FramesWithoutPredictionAreCounted) {
  const fs::path predictions = write_predictions();
  for (const char* frame : {"000003", "000004", "000009"}) fs::remove(predictions / (std::string(frame) + ".json"));
  const ProgramResult result = run({"--predictions", predictions.string()});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(report()["frames"]["used"], 12);
  EXPECT_EQ(report()["frames"]["without_prediction"], 3);
  EXPECT_THAT(result.out, HasSubstr("3 of the frames used had no prediction"));
  EXPECT_EQ(run().exit_code, 0);
  EXPECT_EQ(report()["frames"]["without_prediction"], 0) << "nobody asked for labels";
}

TEST_F(Run, PredictionsOfAnotherRecordingAreAnError) {
  const fs::path predictions = write_predictions();
  for (int i = 0; i < 12; ++i) fs::remove(predictions / fmt::format("{:06}.json", i));
  const ProgramResult result = run({"--predictions", predictions.string(), "--frames", "2:"});
  EXPECT_EQ(result.exit_code, 1);
  expect_one_line(result.err, "no prediction matched a frame");
  expect_one_line(result.err, "2 to 11");
  EXPECT_EQ(report()["frames"]["without_prediction"], 10);
  EXPECT_TRUE(fs::is_regular_file(out_ / "mesh.ply")) << "geometry and colour are kept";
}

TEST_F(Run, AFrameOfNumber0IsAFrameAlsoWhenItIsResumed) {
  const fs::path predictions = write_predictions();
  for (int i = 0; i < 12; ++i) fs::remove(predictions / fmt::format("{:06}.json", i));
  const std::string map = (fresh_folder("map") / "map.panoptic").string();
  for (const bool resumed : {false, true}) {
    const ProgramResult result = run({"--predictions", predictions.string(), "--map", map, "--resume"});
    EXPECT_EQ(result.exit_code, 1) << resumed;
    expect_one_line(result.err, "the 12 frames used are numbered 0 to 11");
  }
}

// Walls, a floor and furniture, which the rules for things that no network knows would make things of.
TEST_F(Run, WithoutNetworksAndPredictionsThereIsNoObjectAndNoLabel) {
  const fs::path home = fresh_folder("homes") / "home";
  ASSERT_EQ(test::run_program({"simulate", "--seed", "1", "--rooms", "1", "--frames", "6", "-o", home.string()}).exit_code, 0);
  const ProgramResult result =
      test::run_program({"run", "--no-pictures", home.string(), "-o", out_.string(), kCoarse[0], kCoarse[1]});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(read_json_file(out_ / "objects.json")["objects"].size(), 0U);
  const Mesh mesh = read_ply(out_ / "mesh.ply");
  EXPECT_GT(mesh.vertices.size(), 1000U);
  for (const MeshVertex& vertex : mesh.vertices) {
    ASSERT_EQ(vertex.class_id, ClassId::kUnknown);
    ASSERT_EQ(static_cast<int>(vertex.panoptic_id), 0);
  }
  const fs::path scores = fresh_folder("scores") / "scores.json";
  const ProgramResult eval = test::run_program({"eval", out_.string(), "--gt", home.string(), "--json", scores.string()});
  ASSERT_EQ(eval.exit_code, 0) << eval.err;
  const Json coverage = read_json_file(scores)["vertices"];
  EXPECT_EQ(coverage["labelled"], 0) << coverage.dump();
  EXPECT_GT(coverage["reached"].get<int>(), 0) << coverage.dump();
}

TEST_F(Run, PredictionsOfAnotherLabelSetAreAnErrorThatNamesBoth) {
  const std::string predictions = write_predictions().string();
  const ProgramResult result = run({"--labels", "scannet20", "--predictions", predictions});
  EXPECT_EQ(result.exit_code, 1);
  expect_one_line(result.err, "'indoor'");
  expect_one_line(result.err, "'scannet20'");
  EXPECT_EQ(run({"--labels", "indoor", "--predictions", predictions}).exit_code, 0);
  EXPECT_EQ(report()["label_set"], "indoor");
}

TEST_F(Run, TheReportNamesTheLabelSetThatWasUsed) {
  ASSERT_EQ(run({"--labels", "home"}).exit_code, 0);
  EXPECT_EQ(report()["label_set"], "home");
  ASSERT_EQ(run().exit_code, 0);
  EXPECT_EQ(report()["label_set"], "indoor");
}

// COCO panoptic whose only category is called as told, for the first frame.
fs::path write_coco(const std::string& category, bool is_thing = true) {
  fs::path folder = fresh_folder("coco");
  write_json_file(
      folder / "panoptic.json",
      {{"images", {{{"id", 1}, {"file_name", "frame-000000.png"}}}},
       {"categories", {{{"id", 5}, {"name", category}, {"isthing", is_thing ? 1 : 0}}}},
       {"annotations", {{{"image_id", 1}, {"file_name", "0.png"}, {"segments_info", {{{"id", 1}, {"category_id", 5}}}}}}}});
  write_png(folder / "0.png", Image<Rgb>(160, 120, Rgb{1, 0, 0}));
  return folder;
}

TEST_F(Run, CocoCategoriesAreTheLabelSetUnlessOneIsAskedFor) {
  const std::string coco = write_coco("samovar").string();
  ASSERT_EQ(run({"--predictions", coco}).exit_code, 0);
  EXPECT_EQ(report()["labels"][0]["name"], "samovar");
  const ProgramResult result = run({"--predictions", coco, "--labels", "indoor"});
  EXPECT_EQ(result.exit_code, 1);
  expect_one_line(result.err, "none of its 1 categories");
  ASSERT_EQ(run({"--predictions", write_coco("wall", false).string(), "--labels", "indoor"}).exit_code, 0);
  EXPECT_EQ(report()["label_set"], "indoor");
}

TEST_F(Run, AFlagWinsOverTheOtherSourceOfLabelsInTheConfig) {
  const fs::path with_networks = fresh_folder("config") / "networks.toml";
  write_file(with_networks, "[networks]\nsemantic = \"/nowhere.toml\"\n");
  EXPECT_EQ(run({"--config", with_networks.string(), "--predictions", write_predictions().string()}).exit_code, 0);
  const fs::path with_predictions = with_networks.parent_path() / "predictions.toml";
  write_file(with_predictions, "predictions = \"/no_predictions\"\n");
  const ProgramResult result = run({"--config", with_predictions.string(), "--instance", "/nowhere.toml"});
  EXPECT_EQ(result.exit_code, 1);
  expect_one_line(result.err, "/nowhere.toml");
}

TEST_F(Run, PredictionsAndNetworksTogetherAreWrongUsage) {
  for (const char* network : {"--semantic", "--instance"}) {
    const ProgramResult result = run({"--predictions", write_predictions().string(), network, "/nowhere.toml"});
    EXPECT_EQ(result.exit_code, 2) << result.err;
    expect_one_line(result.err, "--predictions");
  }
}

}  // namespace
}  // namespace panoptic
