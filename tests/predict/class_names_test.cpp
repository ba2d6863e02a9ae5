// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predict/class_names.h"

#include <gtest/gtest.h>

#include <set>

#include "panoptic/predict/model.h"
#include "tests/places.h"

namespace panoptic {
namespace {

std::string counterpart(std::string_view name, const char* labels = "indoor") {
  const LabelSet set = load_label_set(labels);
  const LabelClass* found = counterpart_of(name, set);
  return found == nullptr ? "" : found->name;
}

TEST(ClassNames, KnowSynonymsOfOtherLabelSets) {
  EXPECT_EQ(counterpart("couch"), "sofa");
  EXPECT_EQ(counterpart("wall-other-merged"), "wall");
  EXPECT_EQ(counterpart("dining table"), "table");
  EXPECT_EQ(counterpart("Potted_Plant"), "plant");
  EXPECT_EQ(counterpart("tv-screen"), "tv");
  EXPECT_EQ(counterpart("floor, flooring"), "floor");
  EXPECT_EQ(counterpart("rug-merged"), "floor");
  EXPECT_EQ(counterpart("armchair"), "chair");
  EXPECT_EQ(counterpart("windowpane", "scannet20"), "window");
  EXPECT_EQ(counterpart("desk", "scannet20"), "desk");
  EXPECT_EQ(counterpart("desk"), "table");
  EXPECT_EQ(counterpart("shelf", "home"), "bookshelf");
}

TEST(ClassNames, LeaveOutWhatHasNoCounterpart) {
  for (const char* name : {"zebra", "background", "__background__", "N/A 12", "no object", "void", ""})
    EXPECT_EQ(counterpart(name), "") << name;
}

TEST(ClassNames, AgreeWithTheShippedClassMaps) {
  for (const char* network : {"enet_scannet_nyu40", "deeplabv3_mnv2_ade20k32", "yolov8n_seg_coco"}) {
    const Model model = load_model(test::source_folder() / "configs/models" / (std::string(network) + ".toml"));
    for (const auto& [label_set, table] : model.class_maps) {
      for (const auto& [from, to] : table) {
        if (from == "whiteboard") continue;  // a choice of that map: no synonym
        EXPECT_EQ(counterpart(from, label_set.c_str()), to) << network << ", " << from;
      }
    }
  }
}

TEST(ClassNames, ListsHaveTheLengthsOfTheirDataSets) {
  for (const std::size_t count : {80U, 81U, 91U, 133U, 150U, 151U, 40U, 41U, 20U, 21U}) {
    const std::vector<ClassList> lists = class_lists_of(count);
    ASSERT_FALSE(lists.empty()) << count;
    for (const ClassList& list : lists) {
      EXPECT_EQ(std::set<std::string>(list.classes.begin(), list.classes.end()).size(), count) << list.name;
    }
  }
}

TEST(ClassNames, KnowTheNumbersOfCocosCategories) {
  EXPECT_EQ(index_of_coco_category(1), 0);
  EXPECT_EQ(index_of_coco_category(62), 56);
  EXPECT_EQ(index_of_coco_category(90), 79);
  for (const int none : {0, 12, 66, 83, 91, -4}) EXPECT_EQ(index_of_coco_category(none), -1) << none;
  EXPECT_EQ(class_lists_of(91).front().classes[62], "chair");
}

}  // namespace
}  // namespace panoptic
