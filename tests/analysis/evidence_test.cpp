// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/analysis/evidence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panoptic/base/files.h"
#include "panoptic/base/json.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

using test::error_of;
using test::fresh_folder;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

Json object(int id, const std::string& class_name) {
  return {
      {"id", id},
      {"class", class_name},
      {"probabilities", {{"table", 0.25}, {class_name, 0.75}}},
      {"box", {{"min_m", {0, 0, 0}}, {"max_m", {1, 2, 3}}}},
      {"oriented_box", {{"size_m", {3, 2, 1}}}},
      {"surface_area_m2", 4.5},
      {"first_frame", 3},
      {"last_frame", 40},
      {"observations", 5},
      {"votes", {{"frames_per_bin", 4}, {"bins", {{{"first_frame", 0}, {"classes", {{"table", 1}, {class_name, 4}}}}}}}},
      {"best_views", {{{"frame", 7}, {"class", class_name}, {"score", 0.5}, {"visible_px", 900}, {"box_px", {10, 20, 50, 60}}}}}};
}

std::filesystem::path write_run(const Json& json) {
  std::filesystem::path run = fresh_folder("run");
  write_json_file(run / "objects.json", json);
  return run;
}

TEST(Evidence, IsWhatTheRunWroteDown) {
  const Evidence e = read_evidence(write_run({{"objects", {object(30, "bed"), object(31, "chair")}}}), 31);
  EXPECT_EQ(e.id, 31);
  EXPECT_EQ(e.class_name, "chair");
  EXPECT_EQ(e.probabilities.front(), (std::pair<std::string, double>("chair", 0.75)));
  ASSERT_EQ(e.stretches.size(), 1U);
  EXPECT_EQ(e.stretches[0].votes.front(), (std::pair<std::string, std::uint64_t>("chair", 4)));
  ASSERT_EQ(e.sights.size(), 1U);
  EXPECT_EQ(e.sights[0].box, (PixelBox{10, 20, 50, 60}));
  const std::string text = to_text(e);
  EXPECT_THAT(text,
              AllOf(HasSubstr("chair 31\n"), HasSubstr("chair 0.750, table 0.250"), HasSubstr("frames 3 to 40, 5 observations"),
                    HasSubstr("chair 4, table 1"), HasSubstr("chair 0.50, 900 px, (10, 20) to (50, 60)"),
                    HasSubstr("3.00 x 2.00 x 1.00 m"), Not(HasSubstr("became"))));
}

TEST(Evidence, AMergedIdIsItsSurvivorHoweverLongTheChain) {
  const auto run = write_run({{"objects", {object(31, "chair")}}, {"merged_into", {{"33", 32}, {"32", 31}}}});
  const Evidence e = read_evidence(run, 33);
  EXPECT_EQ(e.id, 31);
  EXPECT_EQ(e.asked_id, 33);
  EXPECT_THAT(to_text(e), HasSubstr("object 33 became part of 31\nchair 31\n"));
}

TEST(Evidence, AChainOfMergersThatBitesItsTailIsAnError) {
  const auto run = write_run({{"objects", {object(31, "chair")}}, {"merged_into", {{"33", 32}, {"32", 33}}}});
  EXPECT_THAT(error_of([&] { read_evidence(run, 33); }), HasSubstr("no object has the id"));
}

TEST(Evidence, TellsTheHistoryLineByLine) {
  Json with_history = object(31, "chair");
  with_history["history"] = {{{"frame", 20}, {"action", "merge"}, {"other", 33}}, "carved out of table 12"};
  const std::string text = to_text(read_evidence(write_run({{"objects", {with_history}}}), 31));
  EXPECT_THAT(text, HasSubstr("  history\n    frame 20, action merge, other 33\n    carved out of table 12\n"));
}

TEST(Evidence, OfAnOlderRunSaysWhatItLacks) {
  Json old = object(31, "chair");
  old.erase("votes");
  old.erase("best_views");
  const std::string text = to_text(read_evidence(write_run({{"objects", {old}}}), 31));
  EXPECT_THAT(text, AllOf(HasSubstr("votes          not written down"), HasSubstr("best frames    not written down")));
}

TEST(Evidence, AnUnknownIdIsNamedWithThoseThatThereAre) {
  const auto run = write_run({{"objects", {object(31, "chair"), object(40, "bed"), object(52, "bed")}}});
  EXPECT_THAT(error_of([&] { read_evidence(run, 41); }),
              HasSubstr("no object has the id 41; there are 3 from 31 to 52, the nearest is 40"));
  EXPECT_THAT(error_of([&] { read_evidence(write_run({{"objects", Json::array()}}), 41); }), HasSubstr("has no objects"));
}

TEST(Evidence, AFolderWithoutARunIsAnError) {
  EXPECT_THAT(error_of([&] { read_evidence(fresh_folder("empty"), 1); }), HasSubstr("no objects.json"));
}

TEST(Evidence, WhateverIsWrongInTheFileIsNamed) {
  const auto broken = [](const char* key, const Json& value) {
    Json o = object(31, "chair");
    o[key] = value;
    return error_of([&] { read_evidence(write_run({{"objects", {o}}}), 31); });
  };
  EXPECT_THAT(broken("id", -1), HasSubstr("objects[0].id must be"));
  EXPECT_THAT(broken("class", 7), HasSubstr("objects[0].class must be"));
  EXPECT_THAT(broken("probabilities", {{"chair", 2}}), HasSubstr("probabilities.chair must be"));
  EXPECT_THAT(broken("box", {{"min_m", {0, 0}}, {"max_m", {1, 2, 3}}}), HasSubstr("box.min_m must be three numbers"));
  EXPECT_THAT(broken("votes", {{"frames_per_bin", 0}}), HasSubstr("votes.frames_per_bin must be"));
  EXPECT_THAT(broken("surface_area_m2", nullptr), HasSubstr("surface_area_m2 must be"));
  Json view = object(31, "chair")["best_views"];
  view[0]["box_px"] = {50, 20, 10, 60};
  EXPECT_THAT(broken("best_views", view), HasSubstr("box_px must be a box that is not empty"));
  view[0]["box_px"] = {0, 0, 1, 1e12};
  EXPECT_THAT(broken("best_views", view), HasSubstr("best_views[0].box_px[3] must be"));
  const auto run = write_run({{"objects", {object(31, "chair")}}, {"merged_into", {{"x33", 31}}}});
  EXPECT_THAT(error_of([&] { read_evidence(run, 31); }), HasSubstr("merged_into must be an object whose keys are ids"));
}

}  // namespace
}  // namespace panoptic
