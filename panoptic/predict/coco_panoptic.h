// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Predictions or annotations in the COCO panoptic format: one JSON file and a folder of RGB PNG files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/labels.h"
#include "panoptic/segmentation.h"

namespace panoptic {

struct CocoSegment {
  std::uint32_t id = 0;  // red + 256 green + 65536 blue of its pixels, or their grey value
  ClassId class_id = ClassId::kUnknown;
  float score = 1;
  bool is_crowd = false;  // several things that were not told apart
};

struct CocoPanoptic {
  struct Picture {
    std::filesystem::path png;
    std::vector<CocoSegment> segments;  // sorted by id
  };

  LabelSet labels;
  std::map<std::int64_t, Picture> pictures;  // by frame number
  std::string unmatched;                     // a line about the categories that the label set lacks; empty if there are none
};

// The COCO panoptic file that a path means: a JSON file itself, or the only one in a folder. Nothing if there is none.
std::optional<std::filesystem::path> find_coco_panoptic(const std::filesystem::path& path);

// The frame number of a picture is the last number in its image's file name, or its position in the list of images where one
// has no number or two share one. Categories become classes of `labels` by name (class_names.h), others are unknown, but
// not all of them; without `labels` the categories are the label set. Throws Error naming the file.
CocoPanoptic read_coco_panoptic(const std::filesystem::path& json, const std::optional<LabelSet>& labels);

// Reads one frame; empty where there is no picture for it. Stuff of one class becomes one segment, and so do the crowds of a
// thing class: is_whole_class. Throws Error naming the file.
Segmentation read_coco_frame(const CocoPanoptic& coco, std::int64_t frame_index);

}  // namespace panoptic
