// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// "Why is this a chair?": what a run on disk (docs/outputs.md) says about one object.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/objects.h"

namespace panoptic {

struct Evidence {
  std::uint32_t asked_id = 0;
  std::uint32_t id = 0;  // another one if the object that was asked for became part of it
  std::string class_name;
  std::vector<std::pair<std::string, double>> probabilities;  // the most probable first

  std::int64_t first_frame = 0;
  std::int64_t last_frame = 0;
  std::uint64_t observations = 0;

  struct Stretch {
    std::int64_t first_frame = 0;
    std::vector<std::pair<std::string, std::uint64_t>> votes;  // the most frequent first
  };
  std::uint64_t frames_per_stretch = 0;
  std::vector<Stretch> stretches;  // in order

  struct Sight {
    std::int64_t frame = 0;
    std::string class_name;
    double score = 0;
    std::uint64_t visible_px = 0;
    PixelBox box;
  };
  std::vector<Sight> sights;  // the best first

  Vec3d min_m = Vec3d::Zero();
  Vec3d max_m = Vec3d::Zero();
  Vec3d size_m = Vec3d::Zero();  // of the oriented box
  double area_m2 = 0;
  std::vector<std::string> history;  // what object maintenance did to it, a line each
};

// Throws Error if the folder holds no run, if a file of it is not as documented, or if there is no such object.
Evidence read_evidence(const std::filesystem::path& run, std::uint32_t id);

// Several lines for a person.
std::string to_text(const Evidence& evidence);

}  // namespace panoptic
