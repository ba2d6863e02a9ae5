// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// `panoptic run` from outside: files, options, exit codes.
#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/outputs.h"
#include "panoptic/profile.h"
#include "tests/apps/run_fixture.h"
#include "tests/json_schema.h"
#include "tests/places.h"

namespace panoptic {
namespace {

using test::expect_one_line;
using test::fresh_folder;
using test::JsonSchema;
using test::ProgramResult;
using test::Run;
using test::run_program;
using test::source_folder;
using testing::HasSubstr;
namespace fs = std::filesystem;

TEST_F(Run, WritesEveryPromisedFile) {
  const ProgramResult result = run_with_pictures({"--predictions", write_predictions().string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  for (const char* name : {"mesh.ply", "scene.glb", "objects.json", "report.json", "options.toml"}) {
    EXPECT_TRUE(fs::is_regular_file(out_ / name)) << name;
  }
  int views = 0;
  for (const auto& entry : fs::directory_iterator(out_ / "views")) {
    const Image<Rgb> picture = read_rgb(entry.path());
    EXPECT_GT(
        std::adjacent_find(picture.pixels().begin(), picture.pixels().end(), std::not_equal_to<>()) - picture.pixels().begin(),
        0);
    views++;
  }
  EXPECT_EQ(views, 9);
  const Json report = this->report();
  for (const char* key : {"stages", "frames", "peak_rss_mb", "block_count", "map_hash", "labels", "options"})
    EXPECT_TRUE(report.contains(key)) << key;
  for (const char* stage : {"register", "reference", "track", "integrate", "fusion"}) {
    const Json& s = report["stages"].at(stage);
    EXPECT_EQ(s.at("count"), 12) << stage;
    for (const char* key : {"mean_ms", "p50_ms", "p95_ms", "max_ms"}) EXPECT_GE(s.at(key).get<double>(), 0) << key;
  }
  EXPECT_EQ(report["complete"], true);
  EXPECT_THAT(result.out, HasSubstr("integrate"));
}

TEST_F(Run, WithoutPicturesThoseOfAnEarlierRunAreGone) {
  ASSERT_EQ(run_with_pictures({"--set", "map.voxel_size_m=0.2"}).exit_code, 0);
  write_file(out_ / "views" / "mine.txt", "kept");
  const ProgramResult result = run({"--set", "map.voxel_size_m=0.1"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::Not(HasSubstr("views")));
  EXPECT_TRUE(fs::exists(out_ / "scene.glb"));
  const auto left = fs::directory_iterator(out_ / "views");
  EXPECT_EQ(std::count_if(begin(left), end(left), [](const auto&) { return true; }), 1) << "only what is not ours";
}

TEST_F(Run, TheBallIsOneChairInObjectsAndMesh) {
  ASSERT_EQ(run({"--predictions", write_predictions().string()}).exit_code, 0);
  const Json objects = read_json_file(out_ / "objects.json")["objects"];
  ASSERT_EQ(objects.size(), 1U);
  EXPECT_EQ(objects[0]["class"], "chair");
  EXPECT_EQ(objects[0]["observations"], 12);
  EXPECT_EQ(objects[0]["first_frame"], 0);
  EXPECT_EQ(objects[0]["last_frame"], 11);
  EXPECT_NEAR(objects[0]["probabilities"]["chair"].get<double>(), 1, 1e-6);
  for (const char* key : {"box", "oriented_box", "centroid_m", "surface_area_m2"}) EXPECT_TRUE(objects[0].contains(key)) << key;
  const Mesh mesh = read_ply(out_ / "mesh.ply");
  const auto id = static_cast<PanopticId>(objects[0]["id"].get<int>());
  EXPECT_GT(std::count_if(mesh.vertices.begin(), mesh.vertices.end(), [&](const MeshVertex& v) { return v.panoptic_id == id; }),
            500);
}

TEST_F(Run, ObjectsFitTheirSchema) {
  const JsonSchema schema(read_json_file(source_folder() / "docs/objects.schema.json"));
  ASSERT_EQ(run({"--predictions", write_predictions().string()}).exit_code, 0);
  Json objects = read_json_file(out_ / "objects.json");
  ASSERT_FALSE(objects["objects"].empty());
  EXPECT_EQ(schema.complaint(objects), "");
  objects["objects"][0]["centroid_m"] = {1, 2};
  EXPECT_EQ(schema.complaint(objects), "$.objects[0].centroid_m has too few items");
  objects["objects"][0].erase("centroid_m");
  EXPECT_EQ(schema.complaint(objects), "$.objects[0] has no centroid_m");
  objects["objects"][0]["centroid_m"] = {1, 2, 3};
  objects["objects"][0]["colour"] = "red";
  EXPECT_EQ(schema.complaint(objects), "$.objects[0].colour is not in the schema");
}

TEST_F(Run, WithPredictionsTheMapHashIsTheSameAtAnyThreadCount) {
  const std::string predictions = write_predictions().string();
  std::vector<std::string> hashes;
  for (const char* threads : {"1", "2", "3"}) {
    ASSERT_EQ(run({"--predictions", predictions, "--threads", threads}).exit_code, 0);
    hashes.push_back(report()["map_hash"]);
  }
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_EQ(hashes[0], hashes[2]);
}

TEST_F(Run, AnEarlierRunsOptionsRepeatIt) {
  ASSERT_EQ(run({"--set", "map.voxel_size_m=0.05", "--set", "integrator.method=raycast"}).exit_code, 0);
  const std::string hash = report()["map_hash"];
  const std::string options = (out_ / "options.toml").string();
  ASSERT_EQ(run_program({"run", "--no-pictures", recording_.string(), "-o", out_.string(), "--config", options}).exit_code, 0);
  EXPECT_EQ(report()["map_hash"], hash);
  EXPECT_NEAR(report()["options"]["map"]["voxel_size_m"].get<double>(), 0.05, 1e-6);
}

TEST_F(Run, FramesCountsPositions) {
  ASSERT_EQ(run({"--frames", "2:9:3"}).exit_code, 0);
  EXPECT_EQ(report()["frames"]["used"], 3);
}

TEST_F(Run, WrongUsageIsExitCode2) {
  EXPECT_EQ(run_program({}).exit_code, 2);
  EXPECT_EQ(run_program({"run"}).exit_code, 2);
  EXPECT_EQ(run_program({"fly"}).exit_code, 2);
  EXPECT_EQ(run({"--nonsense"}).exit_code, 2);
  for (const char* range : {"5:2", "a:b", "::0"}) EXPECT_EQ(run({"--frames", range}).exit_code, 2) << range;
  const ProgramResult unknown = run({"--set", "map.voxelsize=0.1"});
  EXPECT_EQ(unknown.exit_code, 2);
  expect_one_line(unknown.err, "map.voxelsize");
  EXPECT_EQ(run({"--set", "map.voxel_size_m=-1"}).exit_code, 2);
  EXPECT_EQ(run_program({"predict", recording_.string(), "-o", out_.string()}).exit_code, 2);
}

TEST_F(Run, HelpAndVersionAreExitCode0) {
  EXPECT_THAT(run_program({"--help"}).out, HasSubstr("Exit codes"));
  EXPECT_THAT(run_program({"run", "--help"}).out, HasSubstr("--semantic"));
  EXPECT_THAT(run_program({"--version"}).out, HasSubstr("panoptic "));
  EXPECT_THAT(run_program({"options"}).out, HasSubstr("integrator.method"));
  EXPECT_EQ(run_program({"--help"}).exit_code, 0);
}

TEST_F(Run, AWrongWorldIsOneLineAndExitCode1) {
  const fs::path text = fresh_folder("models") / "text.onnx";
  write_file(text, "this is not a network");
  const fs::path model = text.parent_path() / "model.toml";
  write_file(model,
             "name = \"x\"\ntask = \"semantic\"\ndecoder = \"semantic_logits\"\nweights = \"text.onnx\"\nclasses = [\"wall\", "
             "\"floor\"]\n"
             "[input]\nwidth = 64\nheight = 64\n");
  const fs::path absent = text.parent_path() / "absent.toml";
  write_file(absent,
             "name = \"x\"\ntask = \"semantic\"\ndecoder = \"semantic_logits\"\nweights = \"nowhere.onnx\"\nclasses = [\"wall\", "
             "\"floor\"]\n"
             "[input]\nwidth = 64\nheight = 64\n");
  const fs::path unknown = text.parent_path() / "unknown.toml";
  write_file(unknown,
             "name = \"x\"\ntask = \"semantic\"\ndecoder = \"semantic_logits\"\nweights = \"text.onnx\"\nclasses = [\"wall\", "
             "\"floor\"]\n"
             "[input]\nwidth = 64\nheight = 64\n[class_map.indoor]\nwall = \"dragon\"\n");
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"run", "/nowhere/at/all", "-o", out_.string()}, "/nowhere/at/all"},
      {{"run", out_.string(), "-o", out_.string()}, out_.string()},
      {{"run", recording_.string(), "-o", out_.string(), "--semantic", "/nowhere.toml"}, "/nowhere.toml"},
      {{"run", recording_.string(), "-o", out_.string(), "--semantic", model.string()}, "text.onnx"},
      {{"run", recording_.string(), "-o", out_.string(), "--semantic", absent.string()}, "nowhere.onnx"},
      {{"run", recording_.string(), "-o", out_.string(), "--semantic", unknown.string()}, "dragon"},
      {{"run", recording_.string(), "-o", out_.string(), "--predictions", "/nowhere"}, "/nowhere"},
      {{"run", recording_.string(), "-o", out_.string(), "--config", "/nowhere.toml"}, "/nowhere.toml"},
      {{"run", recording_.string(), "-o", out_.string(), "--calibration", "/nowhere.toml"}, "/nowhere.toml"},
      {{"run", recording_.string(), "-o", out_.string(), "--labels", "no_such_labels"}, "no_such_labels"},
      {{"run", recording_.string(), "-o", (file(0, "pose.txt") / "out").string()}, "choose another output folder"},
      {{"run", recording_.string(), "-o", "/proc/out"}, "/proc/out"},
      {{"doctor", "/nowhere"}, "/nowhere"},
  };
  for (const auto& [arguments, part] : cases) {
    const ProgramResult result = run_program(arguments);
    EXPECT_EQ(result.exit_code, 1) << part << "\n" << result.err;
    expect_one_line(result.err, part);
  }
}

}  // namespace
}  // namespace panoptic
