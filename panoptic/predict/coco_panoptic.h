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

  std::filesystem::path file;
  LabelSet labels;
  std::map<std::int64_t, Picture> pictures;  // by frame number
  std::string unmatched;                     // a line about the categories that the label set lacks; empty if there are none
  std::int64_t in_order = 0;  // so many images without numbers in their names, of frames 0, 1, 2 ...; 0: all have one
};

// The COCO panoptic file that a path means: a JSON file itself, or the only one in a folder. Nothing if there is none.
std::optional<std::filesystem::path> find_coco_panoptic(const std::filesystem::path& path);

// The frame number of a picture is the last number in its image's file name; where one has none or two share one, that in its
// own; else its position in the list of images. Categories become classes of `labels` by name (class_names.h), others are
// unknown, but not all of them; without `labels` the categories are the label set. Throws Error naming the file.
CocoPanoptic read_coco_panoptic(const std::filesystem::path& json, const std::optional<LabelSet>& labels);

// Reads one frame; empty where there is no picture for it, which is an Error beyond images that go by position. Stuff of one
// class becomes one segment, and so do the crowds of a thing class: is_whole_class. Throws Error naming the file.
Segmentation read_coco_frame(const CocoPanoptic& coco, std::int64_t frame_index);

}  // namespace panoptic
