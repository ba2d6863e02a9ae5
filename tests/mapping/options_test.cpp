// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/options.h"

#include <gmock/gmock.h>

#include <set>

#include "panoptic/base/config.h"
#include "panoptic/base/files.h"
#include "panoptic/mapping/builtin_presets.h"
#include "panoptic/mapping/option_fields.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"
#include "tests/mapping/differing_keys.h"
#include "tests/places.h"

namespace panoptic {
namespace {

using test::differing_keys;
using test::error_of;
using testing::AllOf;
using testing::HasSubstr;

std::string toml_of(Options options) { return to_toml(fields(options)); }

TEST(Presets, TheDefaultChangesNothing) { EXPECT_EQ(toml_of(preset_options(kDefaultPreset)), toml_of(Options{})); }

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

TEST(Options, OneIsSetByItsName) {
  Options options;
  set_option(options, "map.voxel_size_m=0.05");
  EXPECT_EQ(differing_keys(options, Options{}), (std::set<std::string>{"map.voxel_size_m"}));
  EXPECT_THAT(error_of([&] { set_option(options, "map.voxel=1"); }), HasSubstr("map.voxel"));
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
