// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/export.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <sstream>

#include "panoptic/base/config.h"
#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/io/scannet_scan.h"
#include "panoptic/parallel.h"
#include "panoptic/predict/prediction_io.h"
#include "panoptic/sim/zip_file.h"
#include "panoptic/source.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/shared_data.h"

namespace panoptic::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

ExportOptions small_home(const std::string& noise = "drift") {
  ExportOptions options;
  options.rooms = 1;
  options.frames = 8;
  options.noise = noise;
  return options;
}

bool export_to(const fs::path& folder, const ExportOptions& options) {
  const Simulation simulation(simulation_options(options));
  return export_scan(simulation, options, folder, [](std::size_t) { return true; });
}

std::map<std::string, std::string> files_below(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files[fs::relative(entry.path(), folder)] = read_file(entry.path());
  }
  return files;
}

Image<std::uint16_t> read_zipped(const ZipFile& archive, const std::string& entry) {
  const std::string bytes = archive.read(entry, 1 << 24);
  return decode_gray16({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, entry);
}

// One export looked at from all sides, since homes are costly to make.
TEST(Export, IsAScanThatOurReadersRead) {
  const fs::path folder = fresh_folder() / "home";
  const ExportOptions options = small_home();
  const Simulation simulation(simulation_options(options));
  std::size_t heard = 0;
  ASSERT_TRUE(export_scan(simulation, options, folder, [&](std::size_t done) {
    EXPECT_GT(done, heard);
    heard = done;
    return true;
  }));
  EXPECT_EQ(heard, 8U);

  const auto dataset = open_recording(folder);
  ASSERT_EQ(dataset->size(), 8U);
  const SimulatedFrame simulated = simulation.simulate(5);
  const ReadResult read = dataset->read(5);
  ASSERT_TRUE(read.frame) << read.skipped.reason;
  EXPECT_TRUE(read.frame->world_from_camera.isApprox(simulated.frame.world_from_camera, 1e-5));
  EXPECT_EQ(read.frame->depth_camera.width, simulation.camera().width);
  EXPECT_NEAR(read.frame->depth_camera.fx, simulation.camera().fx, 1e-3);
  for (std::size_t i = 0; i < read.frame->depth.size(); ++i) {
    ASSERT_NEAR(read.frame->depth[i], simulated.frame.depth[i], 0.00051) << i;
  }

  const PredictionFolder predictions = open_predictions(folder / "predictions");
  EXPECT_EQ(read_prediction(predictions, 5),
            predict_with_noise(options.prediction_noise, 1, simulated, load_label_set("scannet20")));

  const ZipFile labels(folder / "scene0001_00_2d-label.zip");
  const ZipFile instances(folder / "scene0001_00_2d-instance.zip");
  const Image<std::uint16_t> label = read_zipped(labels, "label/5.png");
  const Image<std::uint16_t> instance = read_zipped(instances, "instance/5.png");
  for (std::size_t i = 0; i < label.size(); ++i) {
    ASSERT_EQ(label[i], scannet_category(simulated.rendering.class_id[i]));
    ASSERT_EQ(instance[i], simulated.rendering.instance[i]);
  }

  const ScanTruth truth = read_scan_truth(folder);
  EXPECT_EQ(truth.scene, "scene0001_00");
  EXPECT_GT(truth.positions.size(), 1000U);

  const std::string poses = read_file(folder / "scene0001_00_true_poses.txt");
  EXPECT_EQ(std::count(poses.begin(), poses.end(), '\n'), 8);
  EXPECT_THAT(read_file(folder / "scene0001_00.txt"), HasSubstr("numDepthFrames = 8\n"));
  EXPECT_FALSE(fs::exists(folder.string() + ".partial"));

  ExportOptions again;
  read_toml_file(folder / "simulation.toml", fields(again));
  ExportOptions same = options;
  EXPECT_EQ(to_toml(fields(again)), to_toml(fields(same)));
}

TEST(Export, GivesTheSameBytesOnAnyNumberOfThreads) {
  const fs::path folder = fresh_folder();
  const ExportOptions options = small_home("kinect");
  set_thread_count(1);
  ASSERT_TRUE(export_to(folder / "one", options));
  set_thread_count(3);
  ASSERT_TRUE(export_to(folder / "three", options));
  set_thread_count(0);
  const auto one = files_below(folder / "one");
  const auto three = files_below(folder / "three");
  ASSERT_EQ(one.size(), three.size());
  for (const auto& [name, bytes] : one) EXPECT_TRUE(three.contains(name) && three.at(name) == bytes) << name;
  EXPECT_FALSE(one.contains("scene0001_00_true_poses.txt"));  // the reported poses are the true ones
}

TEST(Export, LeavesNothingWhenStopped) {
  const fs::path folder = fresh_folder();
  ExportOptions options = small_home("none");
  options.predictions = "none";
  options.frames = 2;
  const Simulation simulation(simulation_options(options));
  EXPECT_FALSE(export_scan(simulation, options, folder / "home", [](std::size_t) { return false; }));
  EXPECT_TRUE(fs::is_empty(folder));

  fs::create_directories(folder / "full");
  write_file(folder / "full" / "notes.txt", "mine");
  const auto keep_on = [](std::size_t) { return true; };
  EXPECT_THAT(error_of([&] { export_scan(simulation, options, folder / "full", keep_on); }),
              HasSubstr("already holds something"));
  fs::create_directories(folder / "other.partial");
  EXPECT_THAT(error_of([&] { export_scan(simulation, options, folder / "other", keep_on); }),
              HasSubstr("earlier simulation was killed"));
  EXPECT_TRUE(fs::exists(folder / "other.partial"));

  fs::create_directories(folder / "empty");
  EXPECT_TRUE(export_scan(simulation, options, folder / "empty/", keep_on));
  EXPECT_TRUE(fs::exists(folder / "empty" / "scene0001_00.sens"));
  EXPECT_FALSE(fs::exists(folder / "empty" / "predictions"));
}

TEST(Export, SaysWhatIsNoSeedAndNoNoise) {
  ExportOptions options;
  options.seed = "seven";
  EXPECT_THAT(error_of([&] { simulation_options(options); }), HasSubstr("'seven' is not understood"));
  options.seed = "7,rooms=2";
  EXPECT_THAT(error_of([&] { simulation_options(options); }), HasSubstr("7,rooms=2"));
  options.seed = "18446744073709551615";
  EXPECT_EQ(simulation_options(options).seed, 18446744073709551615U);
  options.noise = "loud";
  EXPECT_THAT(error_of([&] { simulation_options(options); }), HasSubstr("kinect"));
}

TEST(Export, CategoriesAreThoseOfScannetsMap) {
  PANOPTIC_REQUIRE_SHARED("specs/scannetv2-labels.combined.tsv");
  std::istringstream map(read_file(shared_folder() / "specs/scannetv2-labels.combined.tsv"));
  std::map<int, int> nyu40_of;
  std::string line;
  std::getline(map, line);
  while (std::getline(map, line)) {
    std::istringstream cells(line);
    std::vector<std::string> columns;
    for (std::string cell; columns.size() < 5 && std::getline(cells, cell, '\t');) columns.push_back(cell);
    if (columns.size() == 5 && !columns[4].empty()) nyu40_of[std::stoi(columns[0])] = std::stoi(columns[4]);
  }
  const LabelSet labels = load_label_set("scannet20");
  for (const LabelClass& c : labels.classes()) EXPECT_EQ(nyu40_of[scannet_category(c.id)], number(c.id)) << c.name;
  EXPECT_EQ(scannet_category(ClassId::kUnknown), 0);
}

}  // namespace
}  // namespace panoptic::test
