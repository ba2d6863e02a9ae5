// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/benchmark/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "panoptic/base/image_io.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

Study small_study() {
  Study study;
  study.experiment.homes = {{.seed = 3, .rooms = 1, .frames = 15}};
  study.experiment.settings = {{.name = "oracle", .noise = "none", .predictions = "oracle"},
                               {.name = "coarse", .predictions = "poor", .set = {"map.voxel_size_m=0.08"}},
                               {.name = "true tracking", .predictions = "poor", .substitutes = Substitutes{.tracking = true}}};
  study.groups = {{.title = "All of it", .question = "What is it?", .settings = {"coarse", "true tracking", "oracle"}}};
  return study;
}

// Every part through the text that it is kept in.
std::vector<SettingResult> outcomes(const Experiment& experiment) {
  std::vector<PartResult> results;
  for (const ExperimentPart& part : parts_of(experiment)) {
    const auto result = run_part(experiment, part, [](std::size_t, std::size_t) { return true; });
    results.push_back(part_result_in(Json::parse(to_json(*result).dump()), "part.json"));
  }
  return outcomes_of(experiment, results);
}

const std::vector<SettingResult>& small_outcomes() {
  static const std::vector<SettingResult> kOutcomes = outcomes(small_study().experiment);
  return kOutcomes;
}

double pq(std::size_t outcome) { return small_outcomes()[outcome].scores.panoptic.front().all.pq.value_or(0); }

TEST(Experiment, BetterMasksAndDepthScoreBetter) {
  ASSERT_EQ(small_outcomes().size(), 3U);
  EXPECT_GT(pq(0), 0.75);
  EXPECT_LT(pq(1), pq(0) - 0.2);
  EXPECT_LT(pq(2), pq(0) - 0.1);
  EXPECT_GT(small_outcomes()[0].true_things, 5U);
}

TEST(Experiment, TellsProgressAndStopsWhenTold) {
  const Experiment experiment = small_study().experiment;
  ASSERT_EQ(parts_of(experiment).size(), 2U);  // one per noise
  std::size_t calls = 0;
  const auto result = run_part(experiment, parts_of(experiment)[0], [&](std::size_t done, std::size_t total) {
    EXPECT_EQ(done, ++calls);
    EXPECT_EQ(total, 15U);
    return done < 3;
  });
  EXPECT_FALSE(result);
  EXPECT_EQ(calls, 3U);
}

TEST(Experiment, PartsOfSomethingElseAreRefused) {
  for (const char* text :
       {"{}", R"({"true_things": 1, "settings": [{"counts": "x"}]})", R"({"true_things": -1, "settings": []})"}) {
    EXPECT_THAT(test::error_of([&] { part_result_in(Json::parse(text), "part.json"); }), testing::HasSubstr("part.json")) << text;
  }
}

TEST(Experiment, MistakesShowBeforeTheWork) {
  const auto run_with = [](const Setting& setting) {
    require_sound({.homes = {{.seed = 3, .rooms = 1, .frames = 2}}, .settings = {setting}});
  };
  using testing::HasSubstr;
  EXPECT_THAT(test::error_of([&] { run_with({.name = "x", .set = {"map.voxel_size=0.1"}}); }), HasSubstr("map.voxel_size"));
  EXPECT_THAT(test::error_of([&] { run_with({.name = "x", .noise = "loud"}); }), HasSubstr("kinect"));
  EXPECT_THAT(test::error_of([&] { run_with({.name = "x", .predictions = "perfect"}); }), HasSubstr("maskrcnn"));
}

TEST(Studies, EveryGroupNamesSettingsThatAreThereOnce) {
  for (const Study& study : {full_study(), quick_study()}) {
    std::set<std::string> names;
    for (const Setting& setting : study.experiment.settings) EXPECT_TRUE(names.insert(setting.name).second) << setting.name;
    std::set<std::string> asked;
    for (const Group& group : study.groups) asked.insert(group.settings.begin(), group.settings.end());
    EXPECT_EQ(names, asked);
  }
}

TEST(Studies, OneGroupTakesItsSettingsAlone) {
  const Study study = only(full_study(), "Regularizer");
  ASSERT_EQ(study.groups.size(), 1U);
  EXPECT_EQ(study.experiment.settings.size(), study.groups.front().settings.size());
  EXPECT_THAT(test::error_of([] { only(full_study(), "Weather"); }), testing::HasSubstr("'Voxel size'"));
}

TEST(Report, IsWrittenForPeopleAndPrograms) {
  const auto folder = test::fresh_folder();
  write_report(folder, small_study(), small_outcomes());
  EXPECT_GT(read_rgb(folder / "all_of_it.png").width(), 100);
  const Json json = read_json_file(folder / "report.json");
  EXPECT_DOUBLE_EQ(json["settings"]["oracle"]["pq"]["all"].get<double>(), pq(0));
  const std::string text = markdown(small_study(), small_outcomes());
  EXPECT_THAT(text, testing::HasSubstr("| coarse | "));
  EXPECT_THAT(text, testing::HasSubstr("`--set map.voxel_size_m=0.08`"));
  EXPECT_THAT(text, testing::HasSubstr("![All of it](all_of_it.png)"));
}

TEST(Report, FloorsNameWhatFellThrough) {
  EXPECT_THAT(below(std::vector<Floor>{{"oracle", 0.5, 0.5}}, small_outcomes()), testing::IsEmpty());
  EXPECT_THAT(below(std::vector<Floor>{{"oracle", 1.01, 0}}, small_outcomes()),
              testing::ElementsAre(testing::AllOf(testing::HasSubstr("oracle: PQ"), testing::HasSubstr("below 101.0"))));
}

std::size_t count(const Image<Rgb>& image, const Rgb& color) {
  return static_cast<std::size_t>(std::ranges::count(image.pixels(), color));
}

TEST(Chart, BarsAreAsHighAsTheirValues) {
  const Chart chart{.title = "t", .categories = {"a", "b"}, .series = {{"one", {10, 20}}, {"two", {10, std::nan("")}}}};
  const Image<Rgb> image = draw(chart);
  const double first = static_cast<double>(count(image, {31, 119, 180}));   // 10 + 20 high
  const double second = static_cast<double>(count(image, {255, 127, 14}));  // 10 high
  EXPECT_NEAR(first / second, 3, 0.15);
}

TEST(Chart, DrawsNothingButAxesForNothing) {
  EXPECT_EQ(count(draw({.title = "t"}), {31, 119, 180}), 0U);
  EXPECT_EQ(count(draw({.kind = ChartKind::kLines, .categories = {"a"}, .series = {}}), {31, 119, 180}), 0U);
}

}  // namespace
}  // namespace panoptic
