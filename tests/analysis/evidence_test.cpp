// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/evidence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panoptic/base/files.h"
#include "panoptic/base/json.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/io/run_json.h"

namespace panoptic {
namespace {

using test::error_of;
using test::fresh_folder;
using test::object_json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::filesystem::path write_run(const Json& json) {
  std::filesystem::path run = fresh_folder("run");
  write_json_file(run / "objects.json", json);
  return run;
}

TEST(Evidence, IsWhatTheRunWroteDown) {
  const Evidence e = read_evidence(write_run({{"objects", {object_json(30, "bed"), object_json(31, "chair")}}}), PanopticId{31});
  const std::string text = to_text(e);
  EXPECT_THAT(text,
              AllOf(HasSubstr("chair 31\n"), HasSubstr("chair 0.750, floor 0.250"), HasSubstr("frames 3 to 40, 5 observations"),
                    HasSubstr("chair 4, floor 1"), HasSubstr("chair 0.50, 900 px, (10, 20) to (50, 60)"),
                    HasSubstr("3.00 x 2.00 x 1.00 m"), Not(HasSubstr("became"))));
}

TEST(Evidence, AMergedIdIsItsSurvivorHoweverLongTheChain) {
  const auto run = write_run({{"objects", {object_json(31, "chair")}}, {"merged_into", {{"33", 32}, {"32", 31}}}});
  const Evidence e = read_evidence(run, PanopticId{33});
  EXPECT_EQ(e.object.id, PanopticId{31});
  EXPECT_EQ(e.asked_id, PanopticId{33});
  EXPECT_THAT(to_text(e), HasSubstr("object 33 became part of 31\nchair 31\n"));
}

TEST(Evidence, AChainOfMergersThatBitesItsTailIsAnError) {
  const auto run = write_run({{"objects", {object_json(31, "chair")}}, {"merged_into", {{"33", 32}, {"32", 33}}}});
  EXPECT_THAT(error_of([&] { read_evidence(run, PanopticId{33}); }), HasSubstr("no object has the id"));
}

TEST(Evidence, TellsTheHistoryLineByLine) {
  Json with_history = object_json(31, "chair");
  with_history["history"] = {"after frame 20: joined with object 33", "at the end: too large to be a stool"};
  const std::string text = to_text(read_evidence(write_run({{"objects", {with_history}}}), PanopticId{31}));
  EXPECT_THAT(text, HasSubstr("  history\n    after frame 20: joined with object 33\n    at the end: too large to be a stool\n"));
}

TEST(Evidence, OfAnOlderRunSaysWhatItLacks) {
  Json old = object_json(31, "chair");
  old.erase("votes");
  old.erase("best_views");
  const std::string text = to_text(read_evidence(write_run({{"objects", {old}}}), PanopticId{31}));
  EXPECT_THAT(text, AllOf(HasSubstr("votes          not written down"), HasSubstr("best frames    not written down")));
}

TEST(Evidence, AnUnknownIdIsNamedWithThoseThatThereAre) {
  const auto run = write_run({{"objects", {object_json(31, "chair"), object_json(40, "bed"), object_json(52, "bed")}}});
  EXPECT_THAT(error_of([&] { read_evidence(run, PanopticId{41}); }),
              HasSubstr("no object has the id 41; there are 3 from 31 to 52, the nearest is 40"));
  EXPECT_THAT(error_of([&] {
                read_evidence(write_run({{"objects", Json::array()}}), PanopticId{41});
              }),
              HasSubstr("has no objects"));
}

}  // namespace
}  // namespace panoptic
