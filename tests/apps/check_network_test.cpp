// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/base/json.h"
#include "tests/apps/program.h"
#include "tests/fresh_folder.h"
#include "tests/predict/onnx_writer.h"

namespace panoptic {
namespace {

using test::fresh_folder;
using test::OnnxWriter;
using test::run_program;
using testing::HasSubstr;

// Red is "wall", green "couch", blue "zebra".
std::filesystem::path write_network(float gain) {
  const std::filesystem::path folder = fresh_folder();
  OnnxWriter writer;
  writer.input("x", {1, 3, 6, 8}).metadata("names", "{0: 'wall', 1: 'couch', 2: 'zebra'}");
  test::classifier(writer, "x", "y", {gain, 0, 0, 0, gain, 0, 0, 0, gain}).output("y", {1, 3, 6, 8});
  write_file(folder / "net.onnx", writer.text());
  Image<Rgb> picture(16, 12, Rgb{200, 0, 0});
  for (int v = 0; v < 12; ++v) picture(15, v) = picture(14, v) = {0, 200, 0};
  write_png(folder / "picture.png", picture);
  return folder;
}

TEST(CheckNetwork, SaysWhatTheOutputsAreAndWritesADescription) {
  const std::filesystem::path folder = write_network(9);
  const auto path = [&](const char* name) { return (folder / name).string(); };
  const auto result = run_program({"check-network", path("net.onnx"), path("picture.png"), "--json", path("seen.json"), "--png",
                                   path("seen.png"), "--write", path("net.toml")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out,
              testing::AllOf(HasSubstr("semantic: class logits ('y' 1 x 3 x 6 x 8)"), HasSubstr("2 of 3 have a counterpart"),
                             HasSubstr("wall 87.5 %"), HasSubstr("sofa 12.5 %")));
  const Json json = read_json_file(path("seen.json"));
  EXPECT_EQ(json["decoder"], "semantic_logits");
  EXPECT_EQ(json["classes"][1]["counterpart"], "sofa");
  EXPECT_TRUE(json["classes"][2]["counterpart"].is_null());
  EXPECT_TRUE(read_rgb(path("seen.png")).same_size(16, 12));
  const auto again = run_program({"check-network", path("net.toml"), path("picture.png")});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_THAT(again.out, HasSubstr("sofa 12.5 %"));
}

TEST(CheckNetwork, ReadsANetworkThatDoesNotNameItsClasses) {
  const std::filesystem::path folder = fresh_folder();
  OnnxWriter writer;
  writer.input("x", {1, 3, 6, 8});
  test::classifier(writer, "x", "y", {9, 0, 0, 0, 9, 0, 0, 0, 9}).output("y", {1, 3, 6, 8});
  write_file(folder / "net.onnx", writer.text());
  const auto result = run_program({"check-network", (folder / "net.onnx").string(), "--write", (folder / "net.toml").string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, testing::AllOf(HasSubstr("class logits"), HasSubstr("3 of 3")));
  EXPECT_THAT(read_file(folder / "net.toml"), HasSubstr("\"class 2\""));
}

TEST(CheckNetwork, FailsANetworkThatSaysNothingOfAPicture) {
  const std::filesystem::path folder = write_network(0);
  const auto result = run_program({"check-network", (folder / "net.onnx").string(), (folder / "picture.png").string()});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("never gave a label that counted"));
}

}  // namespace
}  // namespace panoptic
