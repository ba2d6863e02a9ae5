// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// `panoptic view` from outside: the result of a run, opened again.
#include <signal.h>

#include <fstream>

#include "panoptic/base/files.h"
#include "panoptic/base/json.h"
#include "panoptic/outputs.h"
#include "tests/apps/run_fixture.h"
#include "tests/viewer/browser.h"

namespace panoptic {
namespace {

using test::expect_one_line;
using test::fetch;
using test::ProgramResult;
using test::run_program;
using test::RunningProgram;

class View : public test::Run {
 protected:
  // Calls `look` with the viewer's port while the program serves the result, and ends it as Ctrl-C does.
  ProgramResult view(const std::vector<std::string>& more, const std::function<void(std::uint16_t)>& look) const {
    std::vector<std::string> arguments = {"view", out_.string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments, {}, [&](const RunningProgram& program) {
      EXPECT_TRUE(test::wait_for_text(program, program.out, "Ctrl-C"));
      const std::string text = read_file(program.out);
      look(static_cast<std::uint16_t>(std::stoi(text.substr(text.find("http://127.0.0.1:") + 17))));
      ::kill(program.pid, SIGINT);
    });
  }
};

TEST_F(View, ShowsWhatTheRunLeft) {
  ASSERT_EQ(run({"--predictions", write_predictions().string()}).exit_code, 0);
  const ProgramResult result = view({"--port", "0"}, [&](std::uint16_t port) {
    const Json scene = Json::parse(fetch(port, "/api/scene").body);
    EXPECT_EQ(scene["title"], "out");
    EXPECT_EQ(scene["has_confidence"], false);
    const Json state = Json::parse(fetch(port, "/api/state").body);
    EXPECT_EQ(state["run"]["frames_used"], 12);
    EXPECT_EQ(state["run"]["finished"], true);
    EXPECT_EQ(state["path"].size(), 12U) << "of trajectory.txt";
    EXPECT_FALSE(state["chunks"].empty());
    const Json objects = Json::parse(fetch(port, "/api/objects").body)["objects"];
    const auto chair = std::find_if(objects.begin(), objects.end(),
                                    [](const Json& o) { return o["name"].get<std::string>().starts_with("chair_"); });
    EXPECT_NE(chair, objects.end());
  });
  EXPECT_EQ(result.exit_code, 0) << "Ctrl-C is how it ends";
  EXPECT_EQ(result.err, "");
}

TEST_F(View, WhatCannotBeShownIsOneLine) {
  const ProgramResult other = run_program({"view", recording_.string()});
  EXPECT_EQ(other.exit_code, 1);
  expect_one_line(other.err, "no report.json");
  ASSERT_EQ(run().exit_code, 0);
  const ProgramResult open_to_all = run_program({"view", out_.string(), "--bind", "0.0.0.0"});
  EXPECT_EQ(open_to_all.exit_code, 1);
  expect_one_line(open_to_all.err, "--token");
  view({"--port", "0"}, [&](std::uint16_t port) {
    const ProgramResult second = run_program({"view", out_.string(), "--port", std::to_string(port)});
    EXPECT_EQ(second.exit_code, 1);
    expect_one_line(second.err, std::to_string(port));
  });
  EXPECT_EQ(run_program({"view"}).exit_code, 2);
  EXPECT_EQ(run_program({"view", out_.string(), "--port", "70000"}).exit_code, 2);
}

}  // namespace
}  // namespace panoptic
