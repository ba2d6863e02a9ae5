// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// `panoptic run` from outside: files, exit codes, and nothing lost when the world is bad.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <fstream>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/data/labels.h"
#include "panoptic/io/mesh_io.h"
#include "panoptic/predict/prediction_io.h"
#include "tests/apps/program.h"
#include "tests/fusion/scenes.h"

namespace panoptic {
namespace {

using test::fresh_folder;
using test::lines;
using test::ProgramResult;
using test::run_program;
using testing::HasSubstr;
namespace fs = std::filesystem;

class Run : public testing::Test {
 protected:
  Run() : recording_(fresh_folder("recording")), out_(fresh_folder("out")) { test::write_orbit_recording(recording_, 12); }

  ProgramResult run(std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments{"run", recording_.string(), "-o", out_.string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  }
  Json report() const { return read_json_file(out_ / "report.json"); }
  fs::path file(int frame, const std::string& kind) const { return recording_ / fmt::format("frame-{:06}.{}", frame, kind); }

  // Predictions in which the ball is a chair whose segment number changes from frame to frame.
  fs::path write_predictions() const {
    fs::path folder = fresh_folder("predictions");
    const LabelSet labels = load_label_set("indoor");
    const ClassId chair = labels.find("chair")->id;
    const ClassId floor = labels.find("floor")->id;
    PredictionWriter writer(folder, labels, "test");
    for (int i = 0; i < 12; ++i) {
      const Frame frame = test::orbit_frame(i);
      Segmentation s{Image<std::uint16_t>(160, 120), {{chair, 0.8F, {{chair, 1.0F}}}, {floor, 1, {}}}};
      if (i % 2 == 1) std::swap(s.segments[0], s.segments[1]);
      for (int v = 0; v < 120; ++v) {
        for (int u = 0; u < 160; ++u) {
          const Vec3d p = frame.world_from_camera * back_project(frame.depth_camera, u, v, frame.depth(u, v));
          s.segment_at(u, v) = static_cast<std::uint16_t>((p.y() > 0.599) == (i % 2 == 0) ? 2 : 1);
        }
      }
      writer.write(i, s);
    }
    return folder;
  }

  fs::path recording_;
  fs::path out_;
};

void expect_one_line(const std::string& err, const std::string& part) {
  EXPECT_THAT(err, HasSubstr(part));
  const auto all = lines(err);
  EXPECT_EQ(std::count_if(all.begin(), all.end(), [](const std::string& l) { return l.starts_with("panoptic: "); }), 1) << err;
}

TEST_F(Run, WritesEveryPromisedFile) {
  const ProgramResult result = run({"--predictions", write_predictions().string()});
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
  ASSERT_EQ(run({"--config", (out_ / "options.toml").string()}).exit_code, 0);
  EXPECT_EQ(report()["map_hash"], hash);
  EXPECT_NEAR(report()["options"]["map"]["voxel_size_m"].get<double>(), 0.05, 1e-6);
}

TEST_F(Run, FramesCountsPositions) {
  ASSERT_EQ(run({"--frames", "2:9:3"}).exit_code, 0);
  EXPECT_EQ(report()["frames"]["used"], 3);
}

TEST_F(Run, BadFramesAreSkippedCountedAndListed) {
  write_file(file(1, "pose.txt"), "nan 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  write_file(file(2, "pose.txt"), "-inf -inf -inf -inf\n-inf -inf -inf -inf\n-inf -inf -inf -inf\n-inf -inf -inf -inf\n");
  write_png(file(3, "depth.png"), Image<std::uint16_t>(160, 120));
  write_png(file(4, "depth.png"), Image<std::uint16_t>(80, 60, 1000));
  fs::remove(file(5, "color.png"));
  fs::resize_file(file(6, "color.png"), 100);
  fs::resize_file(file(7, "depth.png"), 100);
  const ProgramResult result = run();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json frames = report()["frames"];
  EXPECT_EQ(frames["used"], 5);
  EXPECT_EQ(frames["skipped"], 7);
  ASSERT_EQ(frames["skipped_frames"].size(), 7U);
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_EQ(frames["skipped_frames"][i]["index"], i + 1);
    EXPECT_FALSE(frames["skipped_frames"][i]["reason"].get<std::string>().empty());
  }
  EXPECT_THAT(result.out, HasSubstr("5 frames used, 7 skipped"));
}

TEST_F(Run, ARecordingWithoutAnyUsableFrameStillEndsWithAReport) {
  for (int i = 0; i < 12; ++i) write_png(file(i, "depth.png"), Image<std::uint16_t>(160, 120));
  const ProgramResult result = run();
  EXPECT_EQ(result.exit_code, 1);
  expect_one_line(result.err, "no frame");
  EXPECT_EQ(report()["frames"]["used"], 0);
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

// As a full disk: no file can be longer.
std::function<void()> limit_file_bytes(std::uintmax_t bytes) {
  return [bytes] {
    const rlimit limit{bytes, bytes};
    setrlimit(RLIMIT_FSIZE, &limit);
    std::signal(SIGXFSZ, SIG_IGN);
  };
}

TEST_F(Run, AFullDiskLosesNothingThatWasThere) {
  ASSERT_EQ(run().exit_code, 0);
  const std::string mesh = read_file(out_ / "mesh.ply");
  const std::string report = read_file(out_ / "report.json");
  const ProgramResult result =
      run_program({"run", recording_.string(), "-o", out_.string(), "--set", "map.voxel_size_m=0.03"}, limit_file_bytes(20000));
  EXPECT_EQ(result.exit_code, 1);
  expect_one_line(result.err, "mesh.ply");
  EXPECT_TRUE(read_file(out_ / "mesh.ply") == mesh) << "the older file is untouched";
  EXPECT_TRUE(read_file(out_ / "report.json") == report);
  for (const auto& entry : fs::recursive_directory_iterator(out_)) {
    EXPECT_THAT(entry.path().filename().string(), testing::Not(HasSubstr("partial")));
  }
}

TEST_F(Run, ADiskThatFillsUpMidwayLeavesTheOlderReport) {
  ASSERT_EQ(run({"--set", "map.voxel_size_m=0.2"}).exit_code, 0);
  const auto scene_bytes = std::max(fs::file_size(out_ / "scene.glb"), fs::file_size(out_ / "mesh.ply"));
  const auto view_bytes = fs::file_size(out_ / "views" / "front_color.png");
  ASSERT_LT(scene_bytes, view_bytes) << "so coarse that the pictures are larger than the map";
  ASSERT_EQ(run({"--set", "map.voxel_size_m=0.1"}).exit_code, 0);
  const std::string report = read_file(out_ / "report.json");
  const ProgramResult result = run_program({"run", recording_.string(), "-o", out_.string(), "--set", "map.voxel_size_m=0.2"},
                                           limit_file_bytes((scene_bytes + view_bytes) / 2));
  EXPECT_EQ(result.exit_code, 1);
  expect_one_line(result.err, "front_color.png");
  EXPECT_LE(fs::file_size(out_ / "scene.glb"), scene_bytes) << "written before the disk was full";
  EXPECT_TRUE(read_file(out_ / "report.json") == report) << "no report says that the newer files are complete";
}

TEST_F(Run, CtrlCWritesTheMapSoFarAndMarksItIncomplete) {
  test::write_orbit_recording(recording_, 80);
  const auto interrupt = [](const test::RunningProgram& program) {
    EXPECT_TRUE(test::wait_for_text(program, program.err, "/80 frames"));  // the first is mapped
    kill(program.pid, SIGINT);
  };
  const ProgramResult result = run_program({"run", recording_.string(), "-o", out_.string(), "--set", "map.voxel_size_m=0.006",
                                            "--set", "integrator.method=raycast", "--set", "map.truncation_voxels=20"},
                                           {}, interrupt);
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_EQ(report()["complete"], false);
  EXPECT_EQ(report()["stopped_by"], "interrupted");
  EXPECT_GT(report()["frames"]["used"], 0);
  EXPECT_LT(report()["frames"]["used"], 80);
  EXPECT_GT(read_ply(out_ / "mesh.ply").vertices.size(), 100U);
}

TEST_F(Run, CtrlCBeforeTheFirstFrameStillEndsOrderly) {
  const auto interrupt = [](const test::RunningProgram& program) {
    EXPECT_TRUE(test::wait_for_text(program, program.out, "labels "));
    kill(program.pid, SIGINT);
  };
  const ProgramResult result =
      run_program({"run", recording_.string(), "-o", out_.string(), "--set", "map.voxel_size_m=0.006"}, {}, interrupt);
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_EQ(report()["stopped_by"], "interrupted");
}

// A file that is far too long as JSON values, though not as bytes.
std::string hungry_json() {
  constexpr std::size_t kValues = 30'000'000;
  std::string text = "[0";
  text.reserve(2 * kValues + 2);
  for (std::size_t i = 1; i < kValues; ++i) text += ",0";
  return text + "]";
}

TEST_F(Run, RunningOutOfMemoryKeepsTheMapSoFar) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the sanitizers take more memory than the limit of this test and never fail an allocation";
#endif
  const fs::path predictions = write_predictions();
  write_file(predictions / "000007.json", hungry_json());
  const auto limit_memory = [] {
    const rlimit limit{500'000'000, 500'000'000};
    setrlimit(RLIMIT_DATA, &limit);
  };
  const ProgramResult result =
      run_program({"run", recording_.string(), "-o", out_.string(), "--predictions", predictions.string()}, limit_memory);
  EXPECT_EQ(result.exit_code, 1);
  expect_one_line(result.err, "out of memory; use larger voxels");
  EXPECT_EQ(report()["complete"], false);
  EXPECT_THAT(report()["stopped_by"].get<std::string>(), HasSubstr("out of memory"));
  EXPECT_EQ(report()["frames"]["used"], 7);
  EXPECT_GT(read_ply(out_ / "mesh.ply").vertices.size(), 100U);
}

TEST_F(Run, AFailureOnAFullDiskNamesBoth) {
  const fs::path predictions = write_predictions();
  fs::resize_file(predictions / "000007.png", 60);
  const ProgramResult result = run_program(
      {"run", recording_.string(), "-o", out_.string(), "--predictions", predictions.string()}, limit_file_bytes(20000));
  EXPECT_EQ(result.exit_code, 1);
  expect_one_line(result.err, "000007.png");
  expect_one_line(result.err, "mesh.ply");
}

TEST_F(Run, ADamagedPredictionKeepsTheMapSoFar) {
  const fs::path predictions = write_predictions();
  fs::resize_file(predictions / "000007.png", 60);
  const ProgramResult result = run({"--predictions", predictions.string()});
  EXPECT_EQ(result.exit_code, 1);
  expect_one_line(result.err, "000007.png");
  EXPECT_EQ(report()["complete"], false);
  EXPECT_EQ(report()["frames"]["used"], 7);
}

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
fs::path write_coco(const std::string& category) {
  fs::path folder = fresh_folder("coco");
  write_json_file(
      folder / "panoptic.json",
      {{"images", {{{"id", 1}, {"file_name", "frame-000000.png"}}}},
       {"categories", {{{"id", 5}, {"name", category}, {"isthing", 1}}}},
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
  ASSERT_EQ(run({"--predictions", write_coco("chair").string(), "--labels", "indoor"}).exit_code, 0);
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
