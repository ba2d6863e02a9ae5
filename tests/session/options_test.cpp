// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/session/options.h"

#include <gmock/gmock.h>

#include <set>

#include "panoptic/base/files.h"
#include "panoptic/session/builtin_presets.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/places.h"

namespace panoptic {
namespace {

using test::error_of;
using testing::AllOf;
using testing::HasSubstr;

std::string toml_of(Options options) { return to_toml(fields(options)); }

// The keys whose values differ, by the text of both.
std::set<std::string> differing_keys(Options a, Options b) {
  std::set<std::string> keys;
  const Fields left = fields(a);
  const Fields right = fields(b);
  for (std::size_t i = 0; i < left.size(); ++i) {
    if (to_toml({left[i]}) != to_toml({right[i]})) keys.insert(left[i].key);
  }
  return keys;
}

TEST(Presets, TheDefaultChangesNothing) { EXPECT_EQ(toml_of(preset_options(kDefaultPreset)), toml_of(Options{})); }

TEST(Presets, ThePaperDiffersFromTheDefaultInTheRulesThatItDoesNotHave) {
  const std::set<std::string> keys = differing_keys(preset_options("paper"), Options{});
  for (const char* key :
       {"networks.unknown_share", "networks.keep_whole_classes", "networks.smaller_in_front", "networks.score_threshold",
        "tracker.trust_map", "integrator.object_vote", "objects.enabled", "regularizer.w1", "regularizer.w2"}) {
    EXPECT_EQ(keys.count(key), 1U) << key;
  }
  for (const char* key : {"tracker.iou_threshold", "map.voxel_size_m", "map.truncation_voxels"}) {
    EXPECT_EQ(keys.count(key), 0U) << key << ": the default follows the paper";
  }
}

TEST(Presets, ThePaperHasThePapersValues) {
  const Options paper = preset_options("paper");
  EXPECT_FALSE(paper.objects.enabled);
  EXPECT_FALSE(paper.tracker.trust_map);
  EXPECT_FALSE(paper.networks.segmentation.keep_whole_classes);
  EXPECT_FALSE(paper.networks.segmentation.smaller_in_front);
  EXPECT_EQ(paper.networks.score_threshold, 0.5);
  EXPECT_EQ(paper.networks.unknown_share, 1);
  EXPECT_EQ(paper.integrator.object_vote, 1);
  EXPECT_EQ(paper.tracker.iou_threshold, 0.25F);
  EXPECT_EQ(paper.map.voxel_size_m, 0.024F);
  EXPECT_EQ(paper.map.truncation_voxels, 4);
  EXPECT_EQ(paper.regularizer.w1, 10);
  EXPECT_EQ(paper.regularizer.w2, 15);
  EXPECT_EQ(paper.regularizer.theta_alpha_m, 0.05F);
  EXPECT_EQ(paper.regularizer.theta_beta, 20);
  EXPECT_EQ(paper.regularizer.iterations, 5);
  EXPECT_EQ(paper.regularizer.max_blocks, 25);
}

TEST(Presets, AnUnknownOneIsAnErrorThatNamesThoseThereAre) {
  for (const char* name : {"papre", "", "Paper", "../paper"}) {
    EXPECT_THAT(error_of([&] { preset_options(name); }),
                AllOf(HasSubstr(std::string("no preset '") + name + "'"), HasSubstr("default"), HasSubstr("paper")));
  }
}

TEST(Presets, AreTheFilesOfTheRepository) {
  EXPECT_THAT(preset_names(), HasSubstr("paper"));
  const std::filesystem::path file = test::source_folder() / "configs/presets/paper.toml";
  EXPECT_EQ(builtin_preset("paper"), read_file(file));
  EXPECT_EQ(toml_of(load_options(file)), toml_of(preset_options("paper")));
}

TEST(Options, SurviveTheRoundTripThroughTheirText) {
  Options written = preset_options("paper");
  written.objects.merge_share = 0.3F;
  written.networks.semantic = {"a.toml", "b.toml"};
  const std::filesystem::path file = test::fresh_folder() / "options.toml";
  write_file(file, toml_of(written));
  EXPECT_EQ(toml_of(load_options(file)), toml_of(written));
  EXPECT_EQ(differing_keys(load_options(file), preset_options("paper")),
            (std::set<std::string>{"objects.merge_share", "networks.semantic"}));
}

TEST(Options, OfObjectMaintenanceHaveRanges) {
  Options options;
  for (const char* bad : {"objects.merge_share=1.5", "objects.merge_distance_m=-1", "objects.min_observations=-1",
                          "objects.every_frames=0", "objects.size_margin=0.5", "objects.carve=2", "objects.stray_share=nan"}) {
    EXPECT_THAT(error_of([&] { set_field(fields(options), bad); }), HasSubstr("objects.")) << bad;
  }
  EXPECT_EQ(toml_of(options), toml_of(Options{}));
}

}  // namespace
}  // namespace panoptic
