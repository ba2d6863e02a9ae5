// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// `panoptic run --in`: a further visit of a place whose map was saved.
#include "panoptic/base/files.h"
#include "panoptic/map.h"
#include "panoptic/map_file.h"
#include "panoptic/mapper.h"
#include "panoptic/mapping/option_fields.h"
#include "panoptic/predictor.h"
#include "panoptic/source.h"
#include "tests/apps/run_fixture.h"
#include "tests/expect_error.h"

namespace panoptic {
namespace {

using test::fresh_folder;
using test::ProgramResult;
using testing::HasSubstr;
namespace fs = std::filesystem;

constexpr int kSecondFrames = 8;

class RunVisits : public test::Run {
 protected:
  RunVisits() : second_(fresh_folder("second")), predictions_(write_predictions()), maps_(fresh_folder("maps")) {
    test::write_orbit_recording(second_, kSecondFrames);
  }

  ProgramResult first_visit(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"--predictions", predictions_.string(), "--map", first_map().string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }
  ProgramResult second_visit(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"run",      "--no-pictures", second_.string(),     "-o", out_, kCoarse[0],
                                       kCoarse[1], "--predictions", predictions_.string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return test::run_program(arguments);
  }
  ProgramResult second_visit_in_first() const {
    return second_visit({"--in", first_map().string(), "--map", second_map().string()});
  }
  static void expect_refused(const ProgramResult& result, const std::string& part) {
    EXPECT_EQ(result.exit_code, 1);
    test::expect_one_line(result.err, part);
  }
  fs::path first_map() const { return maps_ / "first.panoptic"; }
  fs::path second_map() const { return maps_ / "second.panoptic"; }

  fs::path second_;
  fs::path predictions_;
  fs::path maps_;
};

TEST_F(RunVisits, GoesOnFromTheSavedMapAndLeavesItAsItIs) {
  ASSERT_EQ(first_visit().exit_code, 0);
  const std::string before = read_file(first_map());
  const ProgramResult result = second_visit_in_first();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(read_file(first_map()), before);

  Options options;
  set_option(options, kCoarse[1]);
  const auto predictor = make_file_predictor(predictions_);
  Mapper mapper(options, predictor->labels());
  const auto first = open_recording(recording_);
  for (const Frame& frame : *first) {
    ASSERT_TRUE(mapper.add(frame, predictor->predict(frame)).used);
  }
  mapper.finish();
  const auto second = open_recording(second_);
  for (Frame frame : *second) {
    const Segmentation segmentation = predictor->predict(frame);
    frame.index += kFrames;
    ASSERT_TRUE(mapper.add(frame, segmentation).used);
  }
  mapper.finish();
  EXPECT_EQ(report()["map_hash"], fmt::format("{:016x}", mapper.map().voxels.hash()));
  EXPECT_EQ(load_map(second_map()).map.voxels.hash(), mapper.map().voxels.hash());
  EXPECT_EQ(report()["frames"]["used"], kFrames + kSecondFrames);
  ASSERT_EQ(report()["recordings"].size(), 2U);
  EXPECT_EQ(report()["recordings"][0]["recording"], recording_.string());
  EXPECT_EQ(report()["recordings"][1]["first_frame"], kFrames);
}

TEST_F(RunVisits, AThirdVisitGoesOnFromTheSecond) {
  ASSERT_EQ(first_visit().exit_code, 0);
  ASSERT_EQ(second_visit_in_first().exit_code, 0);
  const ProgramResult third = second_visit({"--in", second_map().string(), "--map", (maps_ / "third.panoptic").string()});
  ASSERT_EQ(third.exit_code, 0) << third.err;
  EXPECT_EQ(report()["frames"]["used"], kFrames + 2 * kSecondFrames);
  EXPECT_EQ(report()["recordings"].size(), 3U);
}

TEST_F(RunVisits, RefusesWhatWouldMakeAnotherMapOfTheFirst) {
  const std::vector<std::string> in_first = {"--in", first_map().string(), "--map", second_map().string()};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), in_first.begin(), in_first.end());
    return second_visit(more);
  };
  expect_refused(with({}), "first.panoptic");
  ASSERT_EQ(first_visit().exit_code, 0);
  expect_refused(with({"--set", "map.voxel_size_m=0.05"}),
                 "first.panoptic has another kind of map: there it says 'voxel_size_m = 0.06', here 'voxel_size_m = 0.05'");
  EXPECT_FALSE(is_there(second_map()));
  ASSERT_EQ(with({}).exit_code, 0);
  expect_refused(with({}), "second.panoptic is there already");
  EXPECT_EQ(with({"--resume"}).exit_code, 0);
  expect_refused(
      run({"--predictions", predictions_.string(), "--in", first_map().string(), "--map", second_map().string(), "--resume"}),
      "is of other visits");
  EXPECT_EQ(second_visit({"--in", first_map().string(), "--map", first_map().string(), "--resume"}).exit_code, 2);
  fs::rename(second_map(), maps_ / "renamed.panoptic");
  expect_refused(second_visit({"--in", (maps_ / "renamed.panoptic").string(), "--map", second_map().string()}),
                 "is of other visits");
  for (const char* kind : {"pose.txt", "depth.png", "color.png"}) fs::remove(file(kFrames - 1, kind));
  expect_refused(second_visit({"--in", first_map().string(), "--map", (maps_ / "other.panoptic").string()}),
                 "was made of 12 frames, and its recordings have 11 now");
}

TEST_F(RunVisits, AVisitWithoutALabelIsNoSuccess) {
  ASSERT_EQ(first_visit().exit_code, 0);
  const fs::path none = fresh_folder("none");
  PredictionWriter writer(none, load_label_set("indoor"), "test");
  writer.write(900, prediction(0, load_label_set("indoor")));
  std::vector<std::string> arguments{"run", "--no-pictures", second_.string(), "-o", out_, kCoarse[0], kCoarse[1]};
  for (const std::string& word : {std::string("--predictions"), none.string(), std::string("--in"), first_map().string(),
                                  std::string("--map"), second_map().string()}) {
    arguments.push_back(word);
  }
  expect_refused(test::run_program(arguments), "no prediction matched a frame; the 8 frames used");
}

TEST_F(RunVisits, RefusesWhatDoesNotGoTogether) {
  EXPECT_EQ(second_visit({"--in", first_map().string()}).exit_code, 2);
  const ProgramResult result = second_visit({"--in", first_map().string(), "--map", second_map().string(), "--frames", "0:4"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("--in does not go with"));
}

}  // namespace
}  // namespace panoptic
