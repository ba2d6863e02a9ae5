// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/json.h"

#include <gmock/gmock.h>

#include "panoptic/base/files.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

using test::error_of;
using test::fresh_folder;
using testing::AllOf;
using testing::HasSubstr;

TEST(Json, SurvivesTheRoundTripInItsOrder) {
  const std::filesystem::path folder = fresh_folder();
  const Json json = {{"z", 1}, {"a", {1.5, "text", nullptr}}, {"m", {{"deep", true}}}};
  write_json_file(folder / "file.json", json);
  const Json read = read_json_file(folder / "file.json");
  EXPECT_EQ(read, json);
  EXPECT_EQ(read.begin().key(), "z");
}

TEST(Json, TextThatIsNotUtf8IsReplacedAndNotFatal) {
  const std::filesystem::path folder = fresh_folder();
  write_json_file(folder / "file.json", Json{{"name", "a\xff"}});
  EXPECT_EQ(read_json_file(folder / "file.json")["name"], "a\xef\xbf\xbd");
}

TEST(Json, BrokenFilesAreErrorsWithNameAndPlace) {
  const std::filesystem::path folder = fresh_folder();
  write_file(folder / "cut.json", R"({"a": [1, 2)");
  EXPECT_THAT(error_of([&] { read_json_file(folder / "cut.json"); }), HasSubstr("cut.json: not valid JSON near byte"));
  write_file(folder / "empty.json", "");
  EXPECT_THAT(error_of([&] { read_json_file(folder / "empty.json"); }), HasSubstr("empty.json"));
  EXPECT_THAT(error_of([&] { read_json_file(folder / "absent.json"); }), HasSubstr("absent.json"));
}

TEST(Json, LargeAndDeepFilesAreErrors) {
  const std::filesystem::path folder = fresh_folder();
  write_file(folder / "large.json", std::string(1000, ' '));
  EXPECT_THAT(error_of([&] { read_json_file(folder / "large.json", 999); }), HasSubstr("more than the limit"));
  write_file(folder / "deep.json", std::string(1000000, '['));
  EXPECT_THAT(error_of([&] { read_json_file(folder / "deep.json"); }), HasSubstr("deep.json"));
  std::string closed(1000000, '[');
  write_file(folder / "closed.json", closed + std::string(1000000, ']'));
  EXPECT_NO_THROW(read_json_file(folder / "closed.json"));  // depth is not a stack overflow either
}

std::string object_of(std::size_t members) {
  std::string text = "{";
  for (std::size_t i = 0; i < members; ++i) text += (i == 0 ? "\"" : ", \"") + std::to_string(i) + "\": [{}, \",\\\",\"]";
  return text + "}";
}

// Thirty million took half a gigabyte, and as much again while the failure was on its way, which ended the program.
TEST(Json, RefusesMoreValuesThanAnyFileOfOursBeforeItTakesMemoryForThem) {
  const std::filesystem::path folder = fresh_folder();
  std::string text = "[0";
  for (std::size_t i = 0; i < kMostJsonValues; ++i) text += ",0";
  EXPECT_EQ(json_in(text + "]"), std::nullopt);
  write_file(folder / "hungry.json", text + "]");
  EXPECT_THAT(error_of([&] { read_json_file(folder / "hungry.json"); }), HasSubstr("hungry.json: more than 10000000 values"));
}

// Reading an object takes quadratic time in its members: this one would take hours.
TEST(Json, RefusesObjectsWithMoreMembersThanAnyFileOfOursAtOnce) {
  const std::filesystem::path folder = fresh_folder();
  write_file(folder / "crowded.json", "[1, " + object_of(1000000) + "]");
  EXPECT_THAT(error_of([&] { read_json_file(folder / "crowded.json"); }),
              AllOf(HasSubstr("crowded.json: "), HasSubstr("an object with more than 4096")));
  EXPECT_EQ(json_in(object_of(kMostJsonMembers + 1)), std::nullopt);
  EXPECT_EQ(json_in(object_of(kMostJsonMembers))->size(), kMostJsonMembers);
  write_file(folder / "list.json", "[" + object_of(2) + std::string(10000, ' ') + ", [" + std::string(20000, ' ') + "1, 2]]");
  EXPECT_EQ(read_json_file(folder / "list.json").size(), 2U);
}

TEST(Json, TextsThatAreNotJsonAreNothing) {
  for (const char* text : {"", "{", "\"", "\"\\", "]", "[1,]", "{\"a\"}"}) EXPECT_EQ(json_in(text), std::nullopt) << text;
  EXPECT_EQ(json_in(" [null] "), Json::parse("[null]"));
}

}  // namespace
}  // namespace panoptic
