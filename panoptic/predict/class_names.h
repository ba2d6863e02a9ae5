// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The names that data sets give to their classes: which of them mean the same, and the lists that networks are trained on.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "panoptic/labels.h"

namespace panoptic {

// The class of the label set that a name means: the same name; the same but for case, hyphens and endings such as "-merged"; a
// synonym (couch = sofa); what it is a kind of (armchair: chair). Names in a list ("floor, flooring") are tried one by one.
// nullptr if there is none.
const LabelClass* counterpart_of(std::string_view name, const LabelSet& labels);

// "background", "__background__", "no object" ...: the name of no class.
bool is_background(std::string_view name);

// Whether these are the 80 classes of COCO's detection task, in order.
bool is_coco80(const std::vector<std::string>& classes);

inline constexpr int kLastCocoCategory = 90;

// The position among these 80 of a category number of COCO, 1 to 90 with gaps; -1 if there is none.
int index_of_coco_category(int category);

// A list of classes that networks are trained on.
struct ClassList {
  std::string_view name;  // "ADE20K"
  std::vector<std::string> classes;
};

// The lists of so many classes, most common first; the background counts where it is one of the outputs.
std::vector<ClassList> class_lists_of(std::size_t count);

}  // namespace panoptic
