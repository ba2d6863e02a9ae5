// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/benchmark/studies.h"

#include <fmt/format.h>

#include <algorithm>

#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr int kHomes = 5;
constexpr int kRooms = 4;
constexpr int kFrames = 400;  // of a way that takes a person more than a minute
constexpr std::uint64_t kQuickSeed = 1;
constexpr int kQuickRooms = 2;
constexpr int kQuickFrames = 200;

const char* const kNoCrf = "regularizer.enabled=false";

Setting without_crf(Setting setting) {
  setting.set.emplace_back(kNoCrf);
  return setting;
}

// The paper's rules without the CRF, which is what the substitutes of the error budget do.
Setting bare(Setting setting) {
  setting.preset = "paper";
  return without_crf(std::move(setting));
}

Setting tiles_of(const std::string& name, int blocks) {
  return {.name = name, .set = {"regularizer.max_blocks=" + std::to_string(blocks)}};
}

Setting voxels_of(const std::string& name, const std::string& metres) {
  return {.name = name, .set = {"map.voxel_size_m=" + metres}};
}

// The same frames with perfect ones: what is left is the map's own.
const Setting kAllOracles{.name = "oracle", .noise = "none", .predictions = "oracle"};

void add_error_budget(Study& study) {
  auto& settings = study.experiment.settings;
  settings.push_back(bare({.name = "nothing replaced"}));
  settings.push_back(bare({.name = "true geometry", .noise = "none"}));
  settings.push_back(bare({.name = "true tracking", .substitutes = Substitutes{.tracking = true}}));
  settings.push_back(bare({.name = "all votes stored", .substitutes = Substitutes{.storage = true}}));
  settings.push_back(bare({.name = "true masks", .predictions = "oracle"}));
  settings.push_back(bare({.name = "all true", .noise = "none", .predictions = "oracle"}));
  study.groups.push_back(
      {.title = "Error budget",
       .question = "What is lost where: one stage at a time is replaced by the truth. True geometry: depth without noise. True "
                   "tracking: a mask belongs to the thing that it covers most of. All votes stored: a voxel counts every label "
                   "instead of keeping one. True masks: what perfect networks would see. The rules are the paper's throughout, "
                   "without the regularizer.",
       .settings = {"nothing replaced", "true geometry", "true tracking", "all votes stored", "true masks", "all true"}});
}

void add_masks(Study& study) {
  auto& settings = study.experiment.settings;
  settings.push_back({.name = "default"});
  settings.push_back({.name = "good masks", .predictions = "good"});
  settings.push_back({.name = "poor masks", .predictions = "poor"});
  settings.push_back({.name = "oracle masks", .predictions = "oracle"});
  settings.push_back(kAllOracles);
  study.groups.push_back({.title = "Masks",
                          .question = "How the map follows the networks. Default: masks as of Mask R-CNN, depth as of a Kinect. "
                                      "Oracle: true masks and depth without noise.",
                          .settings = {"poor masks", "default", "good masks", "oracle masks", "oracle"}});
}

void add_rules(Study& study) {
  auto& settings = study.experiment.settings;
  settings.push_back({.name = "no object maintenance", .set = {"objects.enabled=false"}});
  settings.push_back({.name = "one vote an object", .set = {"integrator.object_vote=1"}});
  settings.push_back({.name = "paper", .preset = "paper"});
  settings.push_back({.name = "paper, good masks", .predictions = "good", .preset = "paper"});
  study.groups.push_back(
      {.title = "Label rules",
       .question = "The rules that go beyond the paper, with masks as of Mask R-CNN and with good ones.",
       .settings = {"paper", "default", "no object maintenance", "one vote an object", "paper, good masks", "good masks"}});
}

void add_regularizer(Study& study) {
  auto& settings = study.experiment.settings;
  settings.push_back(without_crf({.name = "no regularizer"}));
  settings.push_back(without_crf({.name = "oracle, no regularizer", .noise = "none", .predictions = "oracle"}));
  const std::vector<std::string> paper = {"regularizer.every_frames=43", "regularizer.w1=10", "regularizer.w2=15",
                                          "regularizer.band_voxels=4"};
  settings.push_back({.name = "paper's CRF", .set = paper});
  settings.push_back({.name = "oracle, paper's CRF", .noise = "none", .predictions = "oracle", .set = paper});
  study.groups.push_back(
      {.title = "Regularizer",
       .question = "With and without the CRF, and with the parameters of the paper (its table of ablations).",
       .settings = {"no regularizer", "default", "paper's CRF", "oracle, no regularizer", "oracle", "oracle, paper's CRF"}});
}

void add_tiles(Study& study) {
  auto& settings = study.experiment.settings;
  settings.push_back(tiles_of("5 blocks", 5));
  settings.push_back(tiles_of("10 blocks", 10));
  settings.push_back(tiles_of("50 blocks", 50));
  settings.push_back(tiles_of("100 blocks", 100));
  settings.push_back(tiles_of("whole map", 0));
  study.groups.push_back({.title = "Map division",
                          .question =
                              "The paper's figure: scores and time of a run of the regularizer against the largest number of "
                              "blocks in a tile. Default: 25 blocks.",
                          .chart = ChartKind::kLines,
                          .measure = Measure::kPqAndTime,
                          .settings = {"5 blocks", "10 blocks", "default", "50 blocks", "100 blocks", "whole map"}});
}

void add_geometry(Study& study) {
  auto& settings = study.experiment.settings;
  settings.push_back({.name = "raycast", .set = {"integrator.method=raycast"}});
  study.groups.push_back({.title = "Integrator",
                          .question = "Projective (default) and the paper's ray casting.",
                          .settings = {"default", "raycast"}});
  settings.push_back(voxels_of("1.6 cm", "0.016"));
  settings.push_back(voxels_of("3.2 cm", "0.032"));
  settings.push_back(voxels_of("4.8 cm", "0.048"));
  study.groups.push_back({.title = "Voxel size",
                          .question = "Default: 2.4 cm.",
                          .chart = ChartKind::kLines,
                          .measure = Measure::kPqAndTime,
                          .settings = {"1.6 cm", "default", "3.2 cm", "4.8 cm"}});
  settings.push_back({.name = "no sensor noise", .noise = "none"});
  settings.push_back({.name = "drift", .noise = "drift"});
  study.groups.push_back({.title = "Sensor",
                          .question = "Depth without noise, as of a Kinect (default), and with poses that drift.",
                          .settings = {"no sensor noise", "default", "drift"}});
}

}  // namespace

Study full_study() {
  Study study;
  for (int seed = 1; seed <= kHomes; ++seed) {
    study.experiment.homes.push_back({.seed = static_cast<std::uint64_t>(seed), .rooms = kRooms, .frames = kFrames});
  }
  add_masks(study);
  add_rules(study);
  add_error_budget(study);
  add_regularizer(study);
  add_tiles(study);
  add_geometry(study);
  return study;
}

Study only(Study study, const std::string& title) {
  const auto group = std::ranges::find(study.groups, title, &Group::title);
  if (group == study.groups.end()) {
    std::string titles;
    for (const Group& g : study.groups) titles += (titles.empty() ? "'" : ", '") + g.title + "'";
    throw Error(fmt::format("no group of settings is called '{}'; there are {}", title, titles));
  }
  study.groups = {Group(*group)};
  std::erase_if(study.experiment.settings, [&](const Setting& s) {
    return std::ranges::find(study.groups.front().settings, s.name) == study.groups.front().settings.end();
  });
  return study;
}

Study quick_study() {
  Study study;
  study.experiment.homes = {{.seed = kQuickSeed, .rooms = kQuickRooms, .frames = kQuickFrames}};
  study.experiment.settings = {{.name = "default"},
                               without_crf({.name = "no regularizer"}),
                               {.name = "oracle masks", .predictions = "oracle"},
                               kAllOracles};
  study.groups = {{.title = "Quick",
                   .question = "Masks as of Mask R-CNN with and without the regularizer, true masks, and true masks with depth "
                               "without noise.",
                   .settings = {"no regularizer", "default", "oracle masks", "oracle"}}};
  return study;
}

}  // namespace panoptic
