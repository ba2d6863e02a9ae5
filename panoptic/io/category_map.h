// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Maps the free text with which annotators label things ("office chair") to the 40 classes of NYU Depth V2, whose numbers are
// the class ids of ScanNet's truth.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "panoptic/data/nyu40.h"
#include "panoptic/labels.h"

namespace panoptic {

// The name of a class, such as "chair": that of ScanNet's benchmark where it has the class. "unknown" for anything outside
// 1..40.
std::string_view nyu40_name(ClassId id);

// The class of that name, in any case, with spaces or without ("night stand", "NightStand"); kUnknown if there is none.
ClassId nyu40_class(std::string_view name);

// Classes by raw label. Immutable once made. The default knows the NYU40 names alone.
class CategoryMap {
 public:
  CategoryMap() = default;
  // Reads scannetv2-labels.combined.tsv: tab separated, columns raw_category and nyu40id by their names in the header line; an
  // empty id is 0. Then only the file's categories are known. Throws Error with file and line.
  explicit CategoryMap(const std::filesystem::path& tsv);

  // The class of a label; kUnknown if the map lacks the label.
  ClassId nyu40(std::string_view raw_label) const;
  bool knows(std::string_view raw_label) const;

 private:
  bool from_file_ = false;
  std::map<std::string, ClassId, std::less<>> classes_;
};

}  // namespace panoptic
