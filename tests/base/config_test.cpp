// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/config.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "panoptic/base/files.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

using test::error_of;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

using TextMap = std::map<std::string, std::string>;

struct Everything {
  bool flag = true;
  int count = 3;
  float ratio = 0.25F;
  double precise = 0.1;
  std::string mode = "fast";
  std::optional<double> limit;
  std::vector<double> numbers = {1, 2.5};
  std::vector<std::string> names = {"a", "b"};
  TextMap map = {{"chair", "seat"}};
  std::map<std::string, TextMap> maps = {{"outer", {{"inner", "x"}}}};
  std::string nested = "n";

  bool operator==(const Everything&) const = default;
};

Fields fields(Everything& e) {
  Fields result = {{"flag", &e.flag, "a flag", {}},
                   {"count", &e.count, "a count", in_range(0, 10)},
                   {"ratio", &e.ratio, "a ratio", in_range(0, 1)},
                   {"group.precise", &e.precise, "a number", {}},
                   {"group.mode", &e.mode, "a choice", one_of({"fast", "slow"})},
                   {"limit", &e.limit, "a limit", {}},  // outside any table after a table: must not land in the table
                   {"numbers", &e.numbers, "numbers", in_range(-1e6, 1e6)},
                   {"names", &e.names, "names", {}},
                   {"map", &e.map, "a map", {}},
                   {"group.maps", &e.maps, "maps", {}}};
  append_group(result, "group.deep", {{"nested", &e.nested, "nested", {}}});
  return result;
}

std::string error_reading(const std::string& text) {
  Everything e;
  return error_of([&] { read_toml_text(text, "file.toml", fields(e)); });
}

TEST(Config, ReadsEveryKindOfField) {
  Everything e;
  read_toml_text(R"(
flag = false
count = 7
ratio = 1
limit = 2.5
numbers = [3, 4.5]
names = ["x"]
map = { table = "desk", "dining table" = "desk" }
[group]
precise = -1e-3
mode = "slow"
maps = { a = { b = "c" } }
deep.nested = "found"
)",
                 "file.toml", fields(e));
  const Everything expected{
      false,  7, 1.0F, -1e-3, "slow", 2.5, {3, 4.5}, {"x"}, {{"table", "desk"}, {"dining table", "desk"}}, {{"a", {{"b", "c"}}}},
      "found"};
  EXPECT_EQ(e, expected);
}

TEST(Config, AStringIsTakenForAListOfOne) {
  Everything e;
  read_toml_text("names = 'alone'", "file.toml", fields(e));
  EXPECT_THAT(e.names, ElementsAre("alone"));
  set_field(fields(e), "names='other.toml'");
  EXPECT_THAT(e.names, ElementsAre("other.toml"));
  set_field(fields(e), "names=bare.toml");
  EXPECT_EQ(e.names, std::vector<std::string>{"bare.toml"});
  set_field(fields(e), "names=['a', 'b']");
  EXPECT_THAT(e.names, ElementsAre("a", "b"));
  EXPECT_EQ(error_reading("names = 1"), "file.toml:1: 'names' must be an array");
}

TEST(Config, AbsentKeysKeepTheirValues) {
  Everything e;
  read_toml_text("count = 4", "file.toml", fields(e));
  Everything expected;
  expected.count = 4;
  EXPECT_EQ(e, expected);
}

TEST(Config, UnknownKeysAreErrorsWithFileLineAndRemedy) {
  EXPECT_THAT(error_reading("flag = true\n\ncuont = 4"), HasSubstr("file.toml:3: unknown key 'cuont'; known here: count,"));
  EXPECT_THAT(error_reading("[group]\nprecise = 1\nmoed = 'fast'"),
              HasSubstr("file.toml:3: unknown key 'group.moed'; known here: deep, maps, mode, precise"));
  EXPECT_THAT(error_reading("\n[gruop]\nmode = 'fast'"), HasSubstr("file.toml:2: unknown key 'gruop'"));
  EXPECT_THAT(error_reading("\"a\\nb\" = 1"), HasSubstr("unknown key 'a b'"));
}

TEST(Config, WrongTypesAreErrorsWithFileAndLine) {
  EXPECT_EQ(error_reading("\nflag = 1"), "file.toml:2: 'flag' must be true or false");
  EXPECT_EQ(error_reading("count = 1.5"), "file.toml:1: 'count' must be a whole number");
  EXPECT_EQ(error_reading("count = true"), "file.toml:1: 'count' must be a whole number");
  EXPECT_EQ(error_reading("ratio = true"), "file.toml:1: 'ratio' must be a number");
  EXPECT_EQ(error_reading("ratio = \"0.5\""), "file.toml:1: 'ratio' must be a number");
  EXPECT_EQ(error_reading("group.mode = 1"), "file.toml:1: 'group.mode' must be a string");
  EXPECT_EQ(error_reading("numbers = 1"), "file.toml:1: 'numbers' must be an array");
  EXPECT_EQ(error_reading("numbers = [1,\n\"2\"]"), "file.toml:2: 'numbers' must be a number");
  EXPECT_EQ(error_reading("names = [1]"), "file.toml:1: 'names' must be a string");
  EXPECT_EQ(error_reading("map = 1"), "file.toml:1: 'map' must be a table of strings");
  EXPECT_EQ(error_reading("map = { a = 1 }"), "file.toml:1: 'map' must be a string");
  EXPECT_EQ(error_reading("group.maps = []"), "file.toml:1: 'group.maps' must be a table of tables of strings");
  EXPECT_EQ(error_reading("limit = 1979-05-27"), "file.toml:1: 'limit' must be a number");
  EXPECT_THAT(error_reading("group = 1"), HasSubstr("unknown key 'group'"));
}

TEST(Config, ValuesOutOfRangeAreErrorsThatNameTheRange) {
  EXPECT_EQ(error_reading("ratio = 1.5"), "file.toml:1: 'ratio' must be between 0 and 1, not 1.5");
  EXPECT_EQ(error_reading("count = -1"), "file.toml:1: 'count' must be between 0 and 10, not -1");
  EXPECT_EQ(error_reading("numbers = [1, 1e7]"), "file.toml:1: 'numbers' must be between -1000000 and 1000000, not 10000000");
  EXPECT_EQ(error_reading("group.mode = \"warp\""), "file.toml:1: 'group.mode' must be one of fast, slow, not \"warp\"");
  EXPECT_THAT(error_reading("group.precise = nan"), HasSubstr("not nan"));
  EXPECT_THAT(error_reading("group.precise = inf"), HasSubstr("not inf"));
}

TEST(Config, NumbersThatDoNotFitTheirTypeAreErrors) {
  int whole = 0;
  float single = 0;
  const Fields open = {{"whole", &whole, "h", {}}, {"single", &single, "h", {}}};
  for (const char* text :
       {"whole = 3000000000", "whole = 9223372036854775807", "whole = -9223372036854775808", "single = 1e39"}) {
    error_of([&] { read_toml_text(text, "t", open); });
  }
  read_toml_text("whole = -2147483647\nsingle = 1e38", "t", open);
  EXPECT_EQ(whole, -2147483647);
  EXPECT_EQ(single, 1e38F);
}

TEST(Config, ALackingRequiredKeyIsAnError) {
  std::string name;
  const Fields needed = {{"name", &name, "the name", required()}};
  EXPECT_THAT(error_of([&] { read_toml_text("", "t.toml", needed); }), HasSubstr("the key 'name' is missing (the name)"));
}

TEST(Config, ArraysOfTablesAppendOneElementPerTable) {
  struct Item {
    int id = 0;
    std::string name = "none";
  };
  std::vector<Item> items;
  const AppendTable append = [&]() -> Fields {
    Item& item = items.emplace_back();
    return {{"id", &item.id, "the id", required()}, {"name", &item.name, "the name", {}}};
  };
  const Fields list = {{"item", append, "an item", {}}};
  read_toml_text("[[item]]\nid = 1\n[[item]]\nid = 2\nname = 'two'\n", "t.toml", list);
  ASSERT_EQ(items.size(), 2U);
  EXPECT_EQ(items[0].id, 1);
  EXPECT_EQ(items[0].name, "none");
  EXPECT_EQ(items[1].name, "two");
  EXPECT_EQ(error_of([&] { read_toml_text("item = [1]", "t.toml", list); }), "t.toml:1: 'item' must be an array of tables");
  EXPECT_EQ(error_of([&] { read_toml_text("item = 1", "t.toml", list); }), "t.toml:1: 'item' must be an array");
  EXPECT_THAT(error_of([&] { read_toml_text("[[item]]\nid = 1\n\n[[item]]\nname = 'x'", "t.toml", list); }),
              HasSubstr("t.toml:4: the key 'id' is missing"));
  EXPECT_THAT(error_of([&] { read_toml_text("[[item]]\nid = 1\ncolour = 2", "t.toml", list); }),
              HasSubstr("t.toml:3: unknown key"));
}

TEST(Config, WhatToTomlWritesReadsBackAsTheSameValues) {
  Everything written{false, 9, 0.1F, 1.0 / 3, "slow", 1e300, {-1.5, 1e-9, 3}, {}, {}, {}, ""};
  Everything read;
  read_toml_text(to_toml(fields(written)), "round trip", fields(read));
  EXPECT_EQ(read, written);
}

TEST(Config, AnyTextSurvivesTheRoundTrip) {
  std::mt19937 random(1);
  const std::vector<std::string> pieces = {"\"",   "'", "'''", "\"\"\"", "\\", "\n", "\r\n", "\t", "\x01",
                                           "\x7f", "é", "目",  "#",      "=",  "[",  "}",    ".",  " "};
  for (int i = 0; i < 300; ++i) {
    const auto text = [&] {
      std::string result;
      for (std::size_t length = random() % 6; length > 0; --length) result += pieces[random() % pieces.size()];
      return result;
    };
    Everything written;
    written.nested = text();
    written.names = {text(), text()};
    written.map = {{text(), text()}, {text(), text()}};
    written.maps = {{text(), {{text(), text()}}}};
    Everything read;
    read_toml_text(to_toml(fields(written)), "round trip", fields(read));
    ASSERT_EQ(read, written) << to_toml(fields(written));
  }
}

TEST(Config, AnyFiniteNumberSurvivesTheRoundTrip) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> mantissa(-10, 10);
  for (int i = 0; i < 300; ++i) {
    double wide = mantissa(random) * std::pow(10.0, static_cast<double>(random() % 600) - 300);
    auto single = static_cast<float>(mantissa(random) * std::pow(10.0, static_cast<double>(random() % 70) - 35));
    const double wide_before = wide;
    const float single_before = single;
    const Fields numbers = {{"wide", &wide, "h", {}}, {"single", &single, "h", {}}};
    const std::string text = to_toml(numbers);
    wide = 0;
    single = 0;
    read_toml_text(text, "round trip", numbers);
    ASSERT_EQ(wide, wide_before) << text;
    ASSERT_EQ(single, single_before) << text;
  }
}

TEST(Config, SetAssignsOneField) {
  Everything e;
  set_field(fields(e), "count=8");
  set_field(fields(e), "group.mode=slow");            // a bare word is text
  set_field(fields(e), "group.deep.nested=\"q t\"");  // so is a quoted one
  set_field(fields(e), "numbers=[7]");
  set_field(fields(e), "limit=0.5");
  EXPECT_EQ(e.count, 8);
  EXPECT_EQ(e.mode, "slow");
  EXPECT_EQ(e.nested, "q t");
  EXPECT_THAT(e.numbers, ElementsAre(7));
  EXPECT_EQ(e.limit, 0.5);
}

TEST(Config, SetDoesNotAskForRequiredKeys) {
  std::string name;
  int count = 0;
  set_field({{"name", &name, "h", required()}, {"count", &count, "h", {}}}, "count=2");
  EXPECT_EQ(count, 2);
}

TEST(Config, SetRefusesNonsenseAndNamesIt) {
  Everything e;
  for (const char* bad : {"", "count", "=3", "count=", "count=x", "count=99", "nosuch=1", "group=1", "count=1\nflag=false",
                          "count=1 2", "group.mode=warp", "flag=yes"}) {
    const std::string message = error_of([&] { set_field(fields(e), bad); });
    EXPECT_THAT(message, HasSubstr("option ")) << bad;
  }
  EXPECT_EQ(error_of([&] { set_field(fields(e), "count=99"); }), "option count=99: 'count' must be between 0 and 10, not 99");
  EXPECT_EQ(e, Everything{});
}

TEST(Config, BrokenTomlIsAnErrorWithTheLine) {
  EXPECT_THAT(error_reading("count = 1\nflag = = 2"), HasSubstr("file.toml:2: not valid TOML"));
  EXPECT_THAT(error_reading("count = 1\ncount = 2"), HasSubstr("file.toml:2: not valid TOML"));
  EXPECT_THAT(error_reading("count = \xff\xfe"), HasSubstr("not valid TOML"));
  EXPECT_THAT(error_reading(std::string("count = 1\0", 10)), HasSubstr("not valid TOML"));
}

TEST(Config, HostileNestingIsAnErrorAndNotAStackOverflow) {
  constexpr int kDepth = 1000000;
  std::string dotted;
  std::string spaced;
  for (int i = 0; i < kDepth; ++i) dotted += "a.";
  for (int i = 0; i < kDepth; ++i) spaced += "a . ";
  EXPECT_THAT(error_reading(dotted + "a = 1"), HasSubstr("nested deeper"));
  EXPECT_THAT(error_reading(spaced + "a = 1"), HasSubstr("nested deeper"));
  EXPECT_THAT(error_reading("[" + dotted + "a]\nb = 1"), HasSubstr("nested deeper"));
  EXPECT_THAT(error_reading("numbers = " + std::string(kDepth, '[')), HasSubstr("not valid TOML"));
}

TEST(Config, DotsInValuesAndCommentsAreNotNesting) {
  Everything e;
  std::string text = "# " + std::string(1000, '.') + "\nnumbers = [";
  for (int i = 0; i < 1000; ++i) text += "0.5, ";
  read_toml_text(text + "]", "file.toml", fields(e));
  EXPECT_EQ(e.numbers.size(), 1000U);
}

TEST(Config, FilesAreNamedInErrors) {
  const std::filesystem::path folder = test::fresh_folder();
  Everything e;
  write_file(folder / "options.toml", "\ncount = 'x'");
  EXPECT_EQ(error_of([&] { read_toml_file(folder / "options.toml", fields(e)); }),
            (folder / "options.toml").string() + ":2: 'count' must be a whole number");
  EXPECT_THAT(error_of([&] { read_toml_file(folder / "absent.toml", fields(e)); }), HasSubstr("absent.toml"));
  write_file(folder / "huge.toml", std::string(5 << 20, '\n'));
  EXPECT_THAT(error_of([&] { read_toml_file(folder / "huge.toml", fields(e)); }), HasSubstr("more than the limit"));
}

TEST(Config, DescribeTellsKeyDefaultRangeAndHelp) {
  Everything e;
  const std::string text = describe(fields(e));
  EXPECT_THAT(text, HasSubstr("  ratio = 0.25 [0 to 1]\n      a ratio\n"));
  EXPECT_THAT(text, HasSubstr("  group.mode = \"fast\" [fast|slow]\n"));
  EXPECT_THAT(text, HasSubstr("  group.deep.nested = \"n\"\n"));
  EXPECT_THAT(text, Not(HasSubstr("inf")));
}

}  // namespace
}  // namespace panoptic
