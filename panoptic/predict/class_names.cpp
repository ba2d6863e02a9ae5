// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predict/class_names.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace panoptic {
namespace {

// Names of one thing in COCO, COCO panoptic, ADE20K, NYU40, ScanNet, Replica and PASCAL VOC, in the form of plain().
constexpr std::string_view kSynonyms[] = {
    "sofa|couch|settee",
    "tv|television|tv monitor|tvmonitor|television receiver|tv screen|television set",
    "table|dining table|diningtable",
    "plant|potted plant|pottedplant|indoor plant|houseplant",
    "refrigerator|fridge|icebox",
    "cabinet|cupboard|base cabinet|wall cabinet|kitchen cabinet",
    "wall|wall brick|wall stone|wall tile|wall wood|wall concrete|wall panel",
    "floor|flooring|floor wood|floor tile|floor stone|floor marble",
    "ceiling|ceiling tile",
    "door|double door",
    "window|windowpane|window glass",
    "curtain|drape|drapery",
    "blinds|blind|window blind",
    "picture|painting|photo",
    "bookshelf|bookcase",
    "shelf|shelves|shelving",
    "counter|countertop",
    "rug|carpet|floor mat|mat|rug carpet",
    "bathtub|bath|tub",
    "book|books",
    "cup|mug",
    "cell phone|cellphone|mobile phone|phone|telephone",
    "microwave|microwave oven",
    "hair drier|hair dryer|hairdryer",
    "remote|remote control|tv remote",
    "keyboard|computer keyboard",
    "mouse|computer mouse",
    "pillow|cushion",
    "night stand|nightstand",
    "otherfurniture|other furniture|furniture other",
    "whiteboard|white board",
    "trash can|garbage bin|ashcan|bin|trashcan|garbage can",
    "motorcycle|motorbike",
    "airplane|aeroplane",
    "box|cardboard",
    "person|human|people",
};

// A kind of something that label sets have more often.
struct Kind {
  std::string_view name;
  std::string_view is_a;
};
constexpr Kind kKinds[] = {{"armchair", "chair"},
                           {"swivel chair", "chair"},
                           {"office chair", "chair"},
                           {"rocking chair", "chair"},
                           {"desk", "table"},
                           {"coffee table", "table"},
                           {"side table", "table"},
                           {"kitchen table", "table"},
                           {"pool table", "table"},
                           {"rug", "floor"},
                           {"blinds", "curtain"},
                           {"shower curtain", "curtain"},
                           {"shelf", "bookshelf"},
                           {"wardrobe", "cabinet"},
                           {"closet", "cabinet"},
                           {"poster", "picture"},
                           {"kitchen island", "counter"},
                           {"screen door", "door"},
                           {"backpack", "bag"},
                           {"handbag", "bag"},
                           {"suitcase", "bag"},
                           {"luggage", "bag"},
                           {"monitor", "tv"},
                           {"crt screen", "tv"},
                           {"flower", "plant"},
                           {"wall plug", "wall"}};

// Lower case, blanks for hyphens and underlines, single blanks.
std::string plain(std::string_view name) {
  std::string result;
  for (const char c : name) {
    const bool is_gap = c == '-' || c == '_' || c == ' ' || c == '\t';
    if (!is_gap) result += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (is_gap && !result.empty() && result.back() != ' ') result += ' ';
  }
  while (result.ends_with(' ')) result.pop_back();
  return result;
}

// Without the endings of COCO's stuff: "wall-other-merged" is wall, "door-stuff" a door.
std::string without_endings(std::string name) {
  for (const std::string_view ending : {" merged", " stuff", " other"}) {
    if (name.ends_with(ending)) name.erase(name.size() - ending.size());
  }
  return name;
}

bool lists(std::string_view synonyms, std::string_view name) {
  for (std::size_t begin = 0; begin <= synonyms.size();) {
    const std::size_t end = std::min(synonyms.find('|', begin), synonyms.size());
    if (synonyms.substr(begin, end - begin) == name) return true;
    begin = end + 1;
  }
  return false;
}

// The class whose own plain name is this one, or is a synonym of it.
const LabelClass* same_thing(std::string_view name, const LabelSet& labels) {
  for (const LabelClass& c : labels.classes()) {
    if (plain(c.name) == name) return &c;
  }
  for (const std::string_view synonyms : kSynonyms) {
    if (!lists(synonyms, name)) continue;
    for (const LabelClass& c : labels.classes()) {
      if (lists(synonyms, plain(c.name))) return &c;
    }
  }
  return nullptr;
}

std::string_view first_synonym(std::string_view name) {
  for (const std::string_view synonyms : kSynonyms) {
    if (lists(synonyms, name)) return synonyms.substr(0, synonyms.find('|'));
  }
  return name;
}

const LabelClass* by_plain_name(const std::string& name, const LabelSet& labels) {
  if (const LabelClass* same = same_thing(name, labels)) return same;
  for (const Kind& kind : kKinds) {
    if (kind.name != first_synonym(name) && kind.name != name) continue;
    if (const LabelClass* wider = same_thing(kind.is_a, labels)) return wider;
  }
  return nullptr;
}

}  // namespace

const LabelClass* counterpart_of(std::string_view name, const LabelSet& labels) {
  if (const LabelClass* same = labels.find(name)) return same;
  if (is_background(name)) return nullptr;
  for (std::size_t begin = 0; begin < name.size();) {
    const std::size_t end = std::min(name.find_first_of(",;", begin), name.size());
    const std::string part = plain(name.substr(begin, end - begin));
    begin = end + 1;
    if (part.empty()) continue;
    if (const LabelClass* found = by_plain_name(part, labels)) return found;
    if (const LabelClass* found = by_plain_name(without_endings(part), labels)) return found;
  }
  return nullptr;
}

bool is_background(std::string_view name) {
  constexpr std::array<std::string_view, 9> kNames = {"background", "bg",      "no object", "void",  "unlabeled",
                                                      "unlabelled", "unknown", "none",      "ignore"};
  std::string text = plain(name);
  if (text.starts_with("n/a")) return true;
  text.erase(0, text.find_first_not_of(' ') == std::string::npos ? 0 : text.find_first_not_of(' '));
  return std::find(kNames.begin(), kNames.end(), text) != kNames.end();
}

}  // namespace panoptic
