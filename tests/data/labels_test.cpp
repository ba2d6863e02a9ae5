// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/labels.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>

#include "panoptic/base/files.h"
#include "panoptic/data/builtin_labels.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/places.h"
#include "tests/shared_data.h"

namespace panoptic {
namespace {

using test::error_of;
using test::fresh_folder;
using testing::HasSubstr;

constexpr ClassId id(int value) { return static_cast<ClassId>(value); }

LabelSet small_set() {
  return {"small", {{id(7), "chair", true, {1, 2, 3}}, {id(1), "wall", false, {4, 5, 6}}, {id(2), "floor", false, {7, 8, 9}}}};
}

std::string error_loading(const std::string& toml) {
  const std::filesystem::path folder = fresh_folder();
  write_file(folder / "set.toml", toml);
  return error_of([&] { load_label_set((folder / "set.toml").string()); });
}

TEST(LabelSet, IsSortedAndFindsByIdAndName) {
  const LabelSet labels = small_set();
  ASSERT_EQ(labels.classes().size(), 3U);
  EXPECT_EQ(labels.classes()[0].name, "wall");
  EXPECT_EQ(labels.classes()[2].name, "chair");
  EXPECT_EQ(labels.find(id(7))->name, "chair");
  EXPECT_EQ(labels.find("floor")->id, id(2));
  EXPECT_EQ(labels.find(id(3)), nullptr);
  EXPECT_EQ(labels.find(ClassId::kUnknown), nullptr);
  EXPECT_EQ(labels.find("table"), nullptr);
  EXPECT_EQ(labels.name_of(id(1)), "wall");
  EXPECT_EQ(labels.name_of(ClassId::kUnknown), "unknown");
  EXPECT_EQ(labels.name_of(id(999)), "unknown");
}

TEST(LabelSet, EveryClassIsThingOrStuffAndUnknownIsNeither) {
  const LabelSet labels = small_set();
  EXPECT_TRUE(labels.is_thing(id(7)));
  EXPECT_FALSE(labels.is_stuff(id(7)));
  EXPECT_TRUE(labels.is_stuff(id(1)));
  EXPECT_FALSE(labels.is_thing(id(1)));
  for (const ClassId none : {ClassId::kUnknown, id(5), id(65535)}) {
    EXPECT_FALSE(labels.is_thing(none));
    EXPECT_FALSE(labels.is_stuff(none));
  }
}

TEST(LabelSet, ObjectIdsStartAboveTheHighestClass) {
  const LabelSet labels = small_set();
  EXPECT_EQ(labels.first_thing(), 8);
  EXPECT_FALSE(labels.is_object(LabelSlot::kUnknown));
  EXPECT_FALSE(labels.is_object(LabelSet::of_class(id(7))));
  EXPECT_TRUE(labels.is_object(static_cast<LabelSlot>(8)));
  EXPECT_EQ(LabelSet().first_thing(), 1);
}

TEST(LabelSet, RefusesBadIdsAndNames) {
  const auto refused = [](std::vector<LabelClass> classes) {
    return error_of([&] { const LabelSet labels("bad", std::move(classes)); });
  };
  EXPECT_THAT(refused({{id(0), "a", true, {}}}), HasSubstr("class 'a' has id 0; ids must be 1..999"));
  EXPECT_THAT(refused({{id(1000), "a", true, {}}}), HasSubstr("has id 1000"));
  EXPECT_THAT(refused({{id(3), "a", true, {}}, {id(1), "b", true, {}}, {id(3), "c", true, {}}}), HasSubstr("share id 3"));
  EXPECT_THAT(refused({{id(1), "a", true, {}}, {id(2), "a", true, {}}}),
              HasSubstr("the name 'a' of class 2 is empty or used twice"));
  EXPECT_THAT(refused({{id(1), "", true, {}}}), HasSubstr("is empty"));
}

TEST(BuiltinLabelSets, AllLoadAndAreTheFilesOfTheRepository) {
  std::string names = builtin_label_set_names();
  std::replace(names.begin(), names.end(), ',', ' ');
  std::istringstream list(names);
  std::set<std::string> found;
  for (std::string name; list >> name;) {
    found.insert(name);
    const LabelSet labels = load_label_set(name);
    EXPECT_EQ(labels.name(), name);
    EXPECT_FALSE(labels.classes().empty());
    const std::string file = test::source_folder().string() + "/configs/labels/" + name + ".toml";
    EXPECT_EQ(builtin_label_set(name), read_file(file)) << file;
    const LabelSet from_file = load_label_set(file);
    EXPECT_EQ(from_file.classes().size(), labels.classes().size());
    const auto has = [&](bool thing) {
      return std::any_of(labels.classes().begin(), labels.classes().end(),
                         [&](const LabelClass& c) { return c.is_thing == thing; });
    };
    EXPECT_TRUE(has(true)) << name;
    EXPECT_TRUE(has(false)) << name;
  }
  EXPECT_THAT(found, testing::IsSupersetOf({"indoor", "scannet20"}));
  EXPECT_EQ(builtin_label_set("nosuch"), std::nullopt);
}

TEST(BuiltinLabelSets, Scannet20IsTheBenchmarksTwentyClasses) {
  const std::vector<std::pair<int, std::string>> expected = {
      {1, "wall"},    {2, "floor"},      {3, "cabinet"},       {4, "bed"},
      {5, "chair"},   {6, "sofa"},       {7, "table"},         {8, "door"},
      {9, "window"},  {10, "bookshelf"}, {11, "picture"},      {12, "counter"},
      {14, "desk"},   {16, "curtain"},   {24, "refrigerator"}, {28, "shower curtain"},
      {33, "toilet"}, {34, "sink"},      {36, "bathtub"},      {39, "otherfurniture"}};
  const LabelSet labels = load_label_set("scannet20");
  ASSERT_EQ(labels.classes().size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(number(labels.classes()[i].id), expected[i].first);
    EXPECT_EQ(labels.classes()[i].name, expected[i].second);
    EXPECT_EQ(labels.classes()[i].is_thing, expected[i].first > 2) << "stuff is wall and floor";
  }
  EXPECT_EQ(labels.first_thing(), 40);
}

TEST(BuiltinLabelSets, Scannet20NumbersAreThoseOfTheLabelTable) {
  PANOPTIC_REQUIRE_SHARED("specs/scannetv2-labels.combined.tsv");
  std::ifstream table(test::shared_folder() / "specs/scannetv2-labels.combined.tsv");
  const auto columns = [](const std::string& line) {
    std::vector<std::string> cells;
    std::istringstream in(line);
    for (std::string cell; std::getline(in, cell, '\t');) cells.push_back(cell);
    return cells;
  };
  std::string line;
  std::getline(table, line);
  const std::vector<std::string> header = columns(line);
  const auto column = [&](const char* name) {
    return static_cast<std::size_t>(std::find(header.begin(), header.end(), name) - header.begin());
  };
  const std::size_t nyu_id = column("nyu40id");
  const std::size_t nyu_class = column("nyu40class");
  ASSERT_LT(std::max(nyu_id, nyu_class), header.size());
  std::set<std::pair<std::string, std::string>> numbered;
  while (std::getline(table, line)) {
    const std::vector<std::string> cells = columns(line);
    if (cells.size() > std::max(nyu_id, nyu_class)) numbered.emplace(cells[nyu_id], cells[nyu_class]);
  }
  const LabelSet labels = load_label_set("scannet20");
  for (const LabelClass& c : labels.classes()) {
    EXPECT_EQ(numbered.count({std::to_string(number(c.id)), c.name}), 1U) << number(c.id) << " " << c.name;
  }
}

TEST(BuiltinLabelSets, IndoorTakesWallFloorAndCeilingAsStuff) {
  const LabelSet labels = load_label_set("indoor");
  for (const char* name : {"wall", "floor", "ceiling"}) {
    ASSERT_NE(labels.find(name), nullptr) << name;
    EXPECT_FALSE(labels.find(name)->is_thing) << name;
  }
  ASSERT_NE(labels.find("chair"), nullptr);
  EXPECT_TRUE(labels.find("chair")->is_thing);
}

TEST(BuiltinLabelSets, KnowTablesAsSupportsAndNoFloorOrWallIs) {
  for (const char* name : {"indoor", "home", "scannet20"}) {
    const LabelSet labels = load_label_set(name);
    std::size_t supports = 0;
    for (const LabelClass& c : labels.classes()) {
      supports += c.is_support ? 1 : 0;
      EXPECT_TRUE(!c.is_support || c.name != "floor") << name;
      EXPECT_TRUE(c.max_size_m == 0 || (c.is_thing && c.max_size_m < 10)) << name << " " << c.name;
    }
    EXPECT_GT(supports, 0U) << name;
    EXPECT_FALSE(labels.is_support(labels.find("wall")->id)) << name;
  }
}

TEST(LoadLabelSet, ReadsAFileOfTheUser) {
  const std::filesystem::path folder = fresh_folder();
  write_file(
      folder / "mine.toml",
      "name = 'mine'\n[[class]]\nid = 5\nname = 'robot'\ncolor = [1, 2, 255]\n[[class]]\nid = 2\nname = 'sky'\nthing = false\n");
  const LabelSet labels = load_label_set((folder / "mine.toml").string());
  EXPECT_EQ(labels.name(), "mine");
  EXPECT_EQ(labels.find("robot")->color, (Rgb{1, 2, 255}));
  EXPECT_TRUE(labels.find("robot")->is_thing);
  EXPECT_TRUE(labels.is_stuff(id(2)));
}

TEST(LoadLabelSet, ReadsWhatThingsStandOnAndHowLongTheyCanBe) {
  const std::filesystem::path folder = fresh_folder();
  write_file(
      folder / "mine.toml",
      "name = 'mine'\n[[class]]\nid = 1\nname = 'desk'\nsupport = true\n[[class]]\nid = 2\nname = 'cup'\nmax_size_m = 0.25\n");
  const LabelSet labels = load_label_set((folder / "mine.toml").string());
  EXPECT_TRUE(labels.is_support(id(1)));
  EXPECT_EQ(labels.find("desk")->max_size_m, 0) << "no limit";
  EXPECT_FALSE(labels.is_support(id(2)));
  EXPECT_EQ(labels.find("cup")->max_size_m, 0.25);
  for (const ClassId none : {ClassId::kUnknown, id(3), id(65535)}) EXPECT_FALSE(labels.is_support(none));
}

TEST(LoadLabelSet, NamesTheFileAndWhatIsWrong) {
  const std::string head = "name = 'x'\n";
  EXPECT_THAT(error_loading(head + "[[class]]\nid = 0\nname = 'a'"),
              HasSubstr("set.toml:3: 'id' must be between 1 and 999, not 0"));
  EXPECT_THAT(error_loading(head + "[[class]]\nid = 70000\nname = 'a'"), HasSubstr("set.toml:3: 'id' must be between 1 and 999"));
  EXPECT_THAT(error_loading(head + "[[class]]\nid = 1"), HasSubstr("set.toml:2: the key 'name' is missing"));
  EXPECT_THAT(error_loading(head + "[[class]]\nname = 'a'"), HasSubstr("the key 'id' is missing"));
  EXPECT_THAT(error_loading(head + "[[class]]\nid = 1\nname = 'a'\nthng = true"), HasSubstr("set.toml:5: unknown key 'thng'"));
  EXPECT_THAT(error_loading(head + "[[class]]\nid = 1\nname = 'a'\ncolor = [1, 2]"),
              HasSubstr("color must be [red, green, blue]"));
  EXPECT_THAT(error_loading(head + "[[class]]\nid = 1\nname = 'a'\ncolor = [1, 2, 256]"),
              HasSubstr("set.toml:5: 'color' must be between"));
  EXPECT_THAT(error_loading(head + "[[class]]\nid = 1\nname = 'a'\n[[class]]\nid = 1\nname = 'b'"),
              HasSubstr("set.toml: label set 'x'"));
  EXPECT_THAT(error_loading(head + "[[class]]\nid = 1\nname = 'a'\nmax_size_m = -1"),
              HasSubstr("set.toml:5: 'max_size_m' must be between 0 and 1000, not -1"));
  EXPECT_THAT(error_loading(head + "[[class]]\nid = 1\nname = 'a'\nsupport = 1"),
              HasSubstr("set.toml:5: 'support' must be true or false"));
  EXPECT_THAT(error_loading(head), HasSubstr("the key 'class' is missing"));
  EXPECT_THAT(error_loading("[[class]]\nid = 1\nname = 'a'"), HasSubstr("the key 'name' is missing"));
  EXPECT_THAT(error_loading("\xff\xd8\xff"), HasSubstr("set.toml"));
  EXPECT_THAT(error_loading(""), HasSubstr("is missing"));
}

TEST(LoadLabelSet, AnUnknownNameListsTheBuiltinOnes) {
  EXPECT_THAT(error_of([] { load_label_set("kitchen"); }),
              testing::AllOf(HasSubstr("no label set 'kitchen'"), HasSubstr("indoor")));
  EXPECT_THAT(error_of([] { load_label_set(""); }), HasSubstr("no label set ''"));
  EXPECT_THAT(error_of([] { load_label_set(std::string(100000, 'a')); }), HasSubstr("no label set"));
  EXPECT_THAT(error_of([] { load_label_set("/"); }), HasSubstr("not a regular file"));
}

int distance(Rgb a, Rgb b) { return std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b); }

TEST(ColorOf, NeighbouringObjectsHaveDistinctColours) {
  const LabelSet labels = small_set();
  const auto color = [&](int k) { return color_of(static_cast<PanopticId>(labels.first_thing() + k), labels); };
  constexpr int kClear = 40;
  for (int k = 0; k < 500; ++k) {
    for (int next = 1; next <= 4; ++next) EXPECT_GT(distance(color(k), color(k + next)), kClear) << k << " and " << k + next;
  }
}

// Pictures of earlier versions have these colours.
TEST(ColorOf, SmallIdsKeepTheirColoursAndLargeOnesHaveSome) {
  const LabelSet labels = small_set();
  const auto color = [&](std::uint32_t k) { return color_of(static_cast<PanopticId>(labels.first_thing() + k), labels); };
  EXPECT_EQ(color(0), (Rgb{242, 109, 109}));
  EXPECT_EQ(color(1), (Rgb{63, 107, 212}));
  EXPECT_GT(distance(color(4'000'000'000), color(4'000'000'001)), 40);
}

TEST(ColorOf, StuffHasItsClassColourAndUnknownIsGrey) {
  const LabelSet labels = small_set();
  EXPECT_EQ(color_of(LabelSet::id_of_class(id(2)), labels), (Rgb{7, 8, 9}));
  const Rgb grey = color_of(PanopticId::kUnknown, labels);
  EXPECT_TRUE(grey.r == grey.g && grey.g == grey.b);
  EXPECT_EQ(color_of(static_cast<PanopticId>(5), labels), grey) << "a stuff number without a class";
}

}  // namespace
}  // namespace panoptic
