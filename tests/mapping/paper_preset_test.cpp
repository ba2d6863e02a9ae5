// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// --preset paper is the letter of the paper, equation by equation (docs/paper.md).
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "panoptic/base/config.h"
#include "panoptic/mapper.h"
#include "panoptic/mapping/option_fields.h"
#include "panoptic/options.h"
#include "panoptic/predict/prediction_io.h"
#include "panoptic/predictor.h"
#include "tests/fresh_folder.h"
#include "tests/mapping/differing_keys.h"

namespace panoptic {
namespace {

using test::differing_keys;

// The paper's value of an option, and its place there.
struct PaperValue {
  const char* place;  // equation, section or table
  const char* assignment;
};

constexpr PaperValue kPaperValues[] = {
    {"Eq. 1: L_t is the likeliest class of the semantic network", "networks.likeliest_first=true"},
    {"Eq. 1: what is in no label set is unknown, however little of it there is", "networks.unknown_share=1"},
    {"Eq. 1: a thing that only the semantic network sees is unknown", "networks.keep_whole_classes=false"},
    {"Eq. 1, left open: of two instances at a pixel the one with the higher score", "networks.smaller_in_front=false"},
    {"Eq. 1, left open: which instances of the network there are", "networks.score_threshold=0.5"},
    {"Eq. 4, section IV-A: theta_U", "tracker.iou_threshold=0.25"},
    {"Eq. 5: a pixel says what the networks say", "tracker.trust_map=false"},
    {"Eq. 6-11, section III-E: rays are cast", "integrator.method=raycast"},
    {"Eq. 6: distances along the ray as they are, whatever the view", "integrator.grazing=false"},
    {"Eq. 6, 8, section IV-A: voxels of 2.4 cm", "map.voxel_size_m=0.024"},
    {"Eq. 6, 8, section IV-A: truncation at 4 voxels", "map.truncation_voxels=4"},
    {"Eq. 8: weights add up without end", "map.max_weight=0"},
    {"Eq. 6-8: what is in front of the band is not recorded", "map.free_space=false"},
    {"Eq. 6-11: what was fused stays", "carving.enabled=false"},
    {"Eq. 1: people are things like others", "moving.classes=false"},
    {"Eq. 6-11: what moves is fused", "moving.points=false"},
    {"section V: moving objects are future work", "moving.objects=false"},
    {"Eq. 9-11: every label weighs w_t", "integrator.object_vote=1"},
    {"Eq. 12: objects are what the tracker made, their class what Eq. 12 says", "objects.enabled=false"},
    {"Eq. 13, section III-G", "regularizer.enabled=true"},
    {"Eq. 13, section IV-A: iterations", "regularizer.iterations=5"},
    {"Eq. 13: every voxel is a node: those of the whole band", "regularizer.band_voxels=4"},
    {"Eq. 13, section IV-C: voxel blocks of a tile", "regularizer.max_blocks=25"},
    {"Eq. 15, section IV-A: w1", "regularizer.w1=10"},
    {"Eq. 15, section IV-A: w2", "regularizer.w2=15"},
    {"Eq. 16, 17, section IV-A: theta_alpha", "regularizer.theta_alpha_m=0.05"},
    {"Eq. 16, section IV-A: theta_beta", "regularizer.theta_beta=20"},
    {"table V: every 10 s at 4.3 frames a second", "regularizer.every_frames=43"},
    {"table V: every 10 s", "online.regularize_every_s=10"},
    {"table V: mesh every second", "online.mesh_every_s=1"},
};

// Options that the paper leaves open (docs/paper.md says what stands there), and those that do not change the map.
const std::set<std::string> kNotInThePaper = {"labels",
                                              "predictions",
                                              "networks.semantic",
                                              "networks.instance",
                                              "networks.engine",
                                              "networks.threads",
                                              "depth.min_m",
                                              "depth.max_m",
                                              "map.memory_limit_mb",
                                              "map.swap_folder",
                                              "map.log",
                                              "map.log_limit_mb",
                                              "map.pose_tolerance_m",
                                              "regularizer.highest_probability",
                                              "mesher.min_weight",
                                              "online.waiting_frames"};

std::string key_of(const PaperValue& value) {
  const std::string assignment = value.assignment;
  return assignment.substr(0, assignment.find('='));
}

TEST(Presets, ThePaperHasThePapersValues) {
  for (const PaperValue& value : kPaperValues) {
    Options paper = preset_options("paper");
    set_field(fields(paper), value.assignment);
    EXPECT_EQ(differing_keys(paper, preset_options("paper")), std::set<std::string>()) << value.place << ": " << value.assignment;
  }
}

// Whoever adds an option says what the paper has there.
TEST(Presets, ThePaperHasAWordOnEveryOptionOrNone) {
  std::set<std::string> known = kNotInThePaper;
  for (const PaperValue& value : kPaperValues) EXPECT_TRUE(known.insert(key_of(value)).second) << value.assignment;
  Options options;
  for (const Field& field : fields(options)) {
    const bool switched_off = field.key.starts_with("objects.") || field.key == "carving.views";
    EXPECT_TRUE(switched_off || known.contains(field.key)) << field.key;
  }
}

TEST(Presets, ThePaperDiffersFromTheDefaultInTheRulesThatItDoesNotHave) {
  EXPECT_EQ(differing_keys(preset_options("paper"), Options{}), (std::set<std::string>{"networks.likeliest_first",
                                                                                       "networks.unknown_share",
                                                                                       "networks.keep_whole_classes",
                                                                                       "networks.smaller_in_front",
                                                                                       "networks.score_threshold",
                                                                                       "map.max_weight",
                                                                                       "map.free_space",
                                                                                       "carving.enabled",
                                                                                       "moving.classes",
                                                                                       "moving.points",
                                                                                       "moving.objects",
                                                                                       "tracker.trust_map",
                                                                                       "integrator.method",
                                                                                       "integrator.grazing",
                                                                                       "integrator.object_vote",
                                                                                       "objects.enabled",
                                                                                       "regularizer.every_frames",
                                                                                       "regularizer.w1",
                                                                                       "regularizer.w2",
                                                                                       "regularizer.band_voxels"}));
}

TEST(Presets, UnderThePaperSavedPredictionsHaveNoWholeClasses) {
  const LabelSet labels = load_label_set("scannet20");
  const ClassId wall{1};
  const ClassId chair{5};
  const Segmentation written{Image<std::uint16_t>(4, 1, {1, 2, 2, 3}),
                             {{chair, 0.9F, {{chair, 1}}}, {chair, 1, {}, true}, {wall, 1, {}}}};
  const std::filesystem::path folder = test::fresh_folder();
  PredictionWriter(folder, labels, "test").write(0, written);
  Options options = preset_options("paper");
  options.predictions = folder.string();
  EXPECT_EQ(make_predictor(options)->predict(Frame()),
            (Segmentation{Image<std::uint16_t>(4, 1, {1, 0, 0, 2}), {{chair, 0.9F, {{chair, 1}}}, {wall, 1, {}}}}));
  options = preset_options(kDefaultPreset);
  options.predictions = folder.string();
  EXPECT_EQ(make_predictor(options)->predict(Frame()), written);
}

}  // namespace
}  // namespace panoptic
