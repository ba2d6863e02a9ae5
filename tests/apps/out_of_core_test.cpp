// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A map that is larger than the memory it may take, from outside.
#include "panoptic/base/json.h"
#include "tests/apps/run_fixture.h"

namespace panoptic {
namespace {

using test::fresh_folder;
using test::run_program;
namespace fs = std::filesystem;

TEST(OutOfCore, SlowlyAHomeIsTheSameMapWithinTheMemoryOfTheProcess) {
  constexpr double kLimit_mb = 120;
  const fs::path home = fresh_folder("home");
  const auto simulated =
      run_program({"simulate", "--seed", "3", "--rooms", "2", "--frames", "90", "--predictions", "good", "-o", home.string()});
  ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
  const auto report_with = [&](const std::vector<std::string>& more) {
    const fs::path out = fresh_folder("out");
    std::vector<std::string> arguments{"run", "--no-pictures", home.string(), "--predictions", (home / "predictions").string(),
                                       "-o",  out.string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto result = run_program(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return read_json_file(out / "report.json");
  };
  const Json whole = report_with({});
  const Json limited = report_with({"--set", fmt::format("map.memory_limit_mb={}", kLimit_mb), "--threads", "2"});
  EXPECT_EQ(limited["map_hash"], whole["map_hash"]);
  EXPECT_EQ(limited["mesh"], whole["mesh"]);
  EXPECT_LT(limited["map_memory_mb"], whole["map_memory_mb"]);  // blocks did leave
  EXPECT_LE(limited["peak_rss_mb"].get<double>(), kLimit_mb);
}

class RunUnderALimit : public test::Run {};

TEST_F(RunUnderALimit, ThatIsTooLowEndsWithTheLeastLimit) {
  const auto result = run({"--set", "map.memory_limit_mb=20"});
  EXPECT_EQ(result.exit_code, 1);
  test::expect_one_line(result.err, "map.memory_limit_mb = 20, but already the first frame takes more; set it to ");
}

}  // namespace
}  // namespace panoptic
