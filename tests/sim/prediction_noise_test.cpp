// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/prediction_noise.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <set>

#include "panoptic/base/config.h"
#include "tests/expect_error.h"
#include "tests/sim/box_world.h"
#include "tests/sim/frame_score.h"

namespace panoptic::test {
namespace {

using ::testing::HasSubstr;

const LabelSet& labels() {
  static const LabelSet kLabels = load_label_set("scannet20");
  return kLabels;
}

const Vec3d kEye{0.5, 2.3, 1.5};

// The same view, as often as asked for.
std::vector<SimulatedFrame> still(int frames) {
  std::vector<SimulatedFrame> result(static_cast<std::size_t>(frames), box_frame(0, kEye));
  for (std::size_t i = 0; i < result.size(); ++i) result[i].frame.index = static_cast<std::int64_t>(i);
  return result;
}

// Steps of 2 cm sideways.
std::vector<SimulatedFrame> moving(int frames) {
  std::vector<SimulatedFrame> result;
  for (int i = 0; i < frames; ++i) result.push_back(box_frame(i, kEye + Vec3d(0, 0.02 * i - 0.4, 0), 0.005 * i));
  return result;
}

PredictionNoise frame_noise() {  // chance of its own in every frame
  PredictionNoise noise;
  noise.object_share = noise.view_share = 0;
  return noise;
}

// The segment that covers most of an instance, if it covers half of it.
const Segment* segment_of(const Segmentation& s, const Rendering& truth, std::uint16_t instance) {
  std::map<std::uint16_t, int> pixels;
  int all = 0;
  for (std::size_t i = 0; i < truth.instance.size(); ++i) {
    if (truth.instance[i] != instance) continue;
    ++pixels[s.segment_at[i]];
    ++all;
  }
  for (const auto& [segment, count] : pixels) {
    if (segment != 0 && 2 * count > all && labels().is_thing(s.segments[segment - 1U].class_id)) return &s.segments[segment - 1U];
  }
  return nullptr;
}

double share_found(const PredictionNoise& noise, std::uint16_t instance, const std::vector<SimulatedFrame>& frames,
                   std::uint64_t seed = 1) {
  int found = 0;
  for (const SimulatedFrame& f : frames) {
    found += segment_of(predict_with_noise(noise, seed, f, labels()), f.rendering, instance) != nullptr ? 1 : 0;
  }
  return static_cast<double>(found) / static_cast<double>(frames.size());
}

TEST(PredictionNoise, OracleGivesTheTruth) {
  const SimulatedFrame f = box_frame(0, kEye);
  const Segmentation s = predict_with_noise(prediction_noise_preset("oracle"), 1, f, labels());
  ASSERT_EQ(check(s, 320, 240).reason, "");
  std::map<std::uint16_t, std::set<std::pair<ClassId, std::uint16_t>>> truths;
  std::set<std::pair<ClassId, std::uint16_t>> all;
  for (std::size_t i = 0; i < f.rendering.depth.size(); ++i) {
    const std::pair truth(f.rendering.class_id[i], f.rendering.instance[i]);
    truths[s.segment_at[i]].insert(truth);
    all.insert(truth);
    const ClassId given = s.segment_at[i] == 0 ? ClassId::kUnknown : s.segments[s.segment_at[i] - 1U].class_id;
    ASSERT_EQ(given, truth.first);
  }
  EXPECT_EQ(truths.size(), all.size());
  for (const auto& [segment, of] : truths) EXPECT_EQ(of.size(), 1U) << "segment " << segment << " mixes things";
  for (const Segment& segment : s.segments) {
    EXPECT_EQ(segment.score, 1);
    const bool certain = segment.class_probabilities == std::vector<ClassProbability>{{segment.class_id, 1}};
    EXPECT_TRUE(certain || (labels().is_stuff(segment.class_id) && segment.class_probabilities.empty()));
  }
}

TEST(PredictionNoise, NumbersTheSegmentsAnewInEveryFrame) {
  const auto frames = still(2);
  const PredictionNoise oracle;
  const Segmentation a = predict_with_noise(oracle, 1, frames[0], labels());
  const Segmentation b = predict_with_noise(oracle, 1, frames[1], labels());
  EXPECT_EQ(a.segments.size(), b.segments.size());
  EXPECT_NE(a.segment_at, b.segment_at);
}

TEST(PredictionNoise, IsTheSameForTheSameSeedAndFrame) {
  const auto frames = still(2);
  for (const std::string& name : prediction_noise_presets()) {
    const PredictionNoise noise = prediction_noise_preset(name);
    const Segmentation s = predict_with_noise(noise, 7, frames[1], labels());
    EXPECT_EQ(s, predict_with_noise(noise, 7, frames[1], labels())) << name;
    EXPECT_NE(s, predict_with_noise(noise, 8, frames[1], labels())) << name;
    EXPECT_EQ(check(s, 320, 240).reason, "");
  }
}

TEST(PredictionNoise, ListsThePresetsWhenThereIsNoneOfTheName) {
  EXPECT_THAT(error_of([] { prediction_noise_preset("best"); }), HasSubstr("'best'; choose one of oracle, good, maskrcnn, poor"));
}

TEST(PredictionNoise, PresetsAreWithinTheirRanges) {
  for (const std::string& name : prediction_noise_presets()) {
    PredictionNoise noise = prediction_noise_preset(name);
    PredictionNoise back;
    EXPECT_NO_THROW(read_toml_text(to_toml(fields(noise)), name, fields(back)));
    EXPECT_EQ(to_toml(fields(back)), to_toml(fields(noise)));
  }
}

TEST(PredictionNoise, MissesAsOftenAsAsked) {
  PredictionNoise noise = frame_noise();
  noise.missed = 0.3F;
  EXPECT_NEAR(share_found(noise, 6, still(150)), 0.7, 0.1);
}

TEST(PredictionNoise, MissesSmallThingsMore) {
  PredictionNoise noise = frame_noise();
  noise.small_px = 150;
  const auto frames = still(60);
  EXPECT_LT(share_found(noise, 9, frames), 0.6);  // the sink
  EXPECT_GT(share_found(noise, 6, frames), 0.9);  // the table
}

TEST(PredictionNoise, MissesFarThingsMore) {
  PredictionNoise noise = frame_noise();
  noise.far_m = 5;
  const auto frames = still(60);
  EXPECT_GT(share_found(noise, 2, frames), share_found(noise, 8, frames) + 0.15);  // chair at 2.5 m, picture at 5.4 m
}

TEST(PredictionNoise, MissesTruncatedThingsMore) {
  PredictionNoise noise = frame_noise();
  noise.truncated = 0.8F;
  std::vector<SimulatedFrame> frames;
  for (int i = 0; i < 60; ++i) frames.push_back(box_frame(i, {2.0, 1.3, 1.2}, 0));
  EXPECT_LT(share_found(noise, 1, frames), 0.9);  // cut off by the image's lower border
  EXPECT_EQ(share_found(noise, 9, frames), 1);    // in the middle
}

TEST(PredictionNoise, MissesTheSameThingsInEveryViewWhereChanceBelongsToThem) {
  PredictionNoise noise;
  noise.missed = 0.5F;
  noise.object_share = 1;
  noise.view_share = 0;
  const auto frames = moving(12);
  int found = 0;
  for (std::uint16_t instance = 1; instance <= 7; ++instance) {
    const double share = share_found(noise, instance, frames, 3);
    EXPECT_TRUE(share == 0 || share == 1) << share;
    found += share == 1 ? 1 : 0;
  }
  EXPECT_GT(found, 0);
  EXPECT_LT(found, 7);
}

TEST(PredictionNoise, ChangesSlowlyWhereChanceBelongsToTheView) {
  const auto frames = moving(40);
  const auto changes = [&](float view_share) {
    PredictionNoise noise = frame_noise();
    noise.missed = 0.5F;
    noise.view_share = view_share;
    int count = 0;
    for (std::uint16_t instance = 1; instance <= 6; ++instance) {
      bool before = false;
      for (std::size_t i = 0; i < frames.size(); ++i) {
        const bool now = segment_of(predict_with_noise(noise, 1, frames[i], labels()), frames[i].rendering, instance) != nullptr;
        count += i > 0 && now != before ? 1 : 0;
        before = now;
      }
    }
    return count;
  };
  EXPECT_LT(4 * changes(1), changes(0));
}

TEST(PredictionNoise, MergesNeighboursOfOneClassAlone) {
  PredictionNoise noise = frame_noise();
  noise.merged = 1;
  const SimulatedFrame f = box_frame(0, kEye);
  const Segmentation s = predict_with_noise(noise, 1, f, labels());
  EXPECT_EQ(segment_of(s, f.rendering, 1), segment_of(s, f.rendering, 2));  // chairs side by side
  EXPECT_EQ(segment_of(s, f.rendering, 3), segment_of(s, f.rendering, 4));
  EXPECT_NE(segment_of(s, f.rendering, 1), segment_of(s, f.rendering, 3));  // two make one, not four
  EXPECT_NE(segment_of(s, f.rendering, 4), segment_of(s, f.rendering, 6));  // chair and table
}

TEST(PredictionNoise, SplitsAThingInTwo) {
  PredictionNoise noise = frame_noise();
  noise.split = 1;
  const SimulatedFrame f = box_frame(0, kEye);
  const Segmentation s = predict_with_noise(noise, 1, f, labels());
  std::map<std::uint16_t, int> parts;
  for (std::size_t i = 0; i < f.rendering.instance.size(); ++i) {
    if (f.rendering.instance[i] == 6) ++parts[s.segment_at[i]];
  }
  ASSERT_EQ(parts.size(), 2U);
  for (const auto& [segment, pixels] : parts) {
    EXPECT_EQ(s.segments[segment - 1U].class_id, ClassId{7});
    EXPECT_GT(pixels, 100);
  }
}

TEST(PredictionNoise, ImaginesThingsAtPlacesThatStay) {
  PredictionNoise noise;
  noise.hallucinated = 0.2F;
  noise.object_share = 1;
  noise.view_share = 0;
  const auto imagined = [&](const SimulatedFrame& f) {
    const Segmentation s = predict_with_noise(noise, 2, f, labels());
    std::set<std::array<int, 3>> places;  // where wall or floor is given as a thing, in cells of 0.3 m
    for (int v = 0; v < 240; v += 4) {
      for (int u = 0; u < 320; u += 4) {
        const int segment = s.segment_at(u, v);
        const bool stuff = f.rendering.instance(u, v) == 0;
        if (!stuff || segment == 0 || labels().is_stuff(s.segments[static_cast<std::size_t>(segment) - 1].class_id)) continue;
        const Vec3d p =
            f.true_world_from_camera * back_project(f.frame.color_camera, u, v, static_cast<double>(f.rendering.depth(u, v)));
        places.insert({static_cast<int>(p.x() / 0.3), static_cast<int>(p.y() / 0.3), static_cast<int>(p.z() / 0.3)});
      }
    }
    return places;
  };
  const auto a = imagined(box_frame(0, kEye));
  const auto b = imagined(box_frame(1, kEye + Vec3d(0.05, 0.1, 0)));
  std::vector<std::array<int, 3>> both;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
  EXPECT_GT(a.size(), 5U);
  EXPECT_GT(2 * both.size(), a.size());
}

// Displaced boundaries stay curves: few pixels have another label than most of their neighbours.
TEST(PredictionNoise, BoundariesStrayWithoutSaltAndPepper) {
  PredictionNoise noise = frame_noise();
  noise.boundary_px = 3;
  const SimulatedFrame f = box_frame(0, kEye);
  const Segmentation s = predict_with_noise(noise, 1, f, labels());
  int moved = 0;
  int lonely = 0;
  for (int v = 1; v < 239; ++v) {
    for (int u = 1; u < 319; ++u) {
      const int segment = s.segment_at(u, v);
      const ClassId given = segment == 0 ? ClassId::kUnknown : s.segments[static_cast<std::size_t>(segment) - 1].class_id;
      moved += given != f.rendering.class_id(u, v) ? 1 : 0;
      int alike = 0;
      for (int dv = -1; dv <= 1; ++dv) {
        for (int du = -1; du <= 1; ++du) alike += s.segment_at(u + du, v + dv) == segment ? 1 : 0;
      }
      lonely += alike <= 2 ? 1 : 0;
    }
  }
  EXPECT_GT(moved, 2000);
  EXPECT_LT(lonely, moved / 40);
}

TEST(PredictionNoise, TakesMostThingsForWhatTheyAreInMostViewsAndSomeForAnotherInAll) {
  PredictionNoise noise;
  noise.confused = 0.25F;
  noise.object_share = 0.7F;
  noise.view_share = 0;
  const auto frames = moving(15);
  int right = 0;
  int always_wrong = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    std::map<std::uint16_t, int> correct;
    for (const SimulatedFrame& f : frames) {
      const Segmentation s = predict_with_noise(noise, seed, f, labels());
      for (const BoxThing& thing : box_things()) {
        const Segment* segment = segment_of(s, f.rendering, thing.instance);
        correct[thing.instance] += segment != nullptr && segment->class_id == thing.class_id ? 1 : 0;
      }
    }
    for (const auto& [instance, views] : correct) {
      right += 2 * views > 15 ? 1 : 0;
      always_wrong += views <= 2 ? 1 : 0;
    }
  }
  EXPECT_GT(right, 25);  // of 40
  EXPECT_GT(always_wrong, 0);
}

TEST(PredictionNoise, ConfusesByTheTable) {
  PredictionNoise noise = frame_noise();
  noise.confused = 1;
  std::set<std::string_view> given;
  for (const SimulatedFrame& f : still(30)) {
    const Segmentation s = predict_with_noise(noise, 1, f, labels());
    const Segment* table = segment_of(s, f.rendering, 6);
    ASSERT_NE(table, nullptr);
    given.insert(labels().name_of(table->class_id));
  }
  EXPECT_THAT(given, testing::Contains("desk"));
  EXPECT_THAT(given, testing::Not(testing::Contains("table")));
  EXPECT_THAT(given, testing::Not(testing::Contains("toilet")));
}

TEST(PredictionNoise, ClassProbabilitiesSumToOneAndTheClassHasTheMost) {
  for (const SimulatedFrame& f : still(5)) {
    for (const Segment& segment : predict_with_noise(prediction_noise_preset("poor"), 1, f, labels()).segments) {
      if (labels().is_stuff(segment.class_id)) continue;
      float sum = 0;
      ClassProbability most;
      for (const ClassProbability& p : segment.class_probabilities) {
        sum += p.probability;
        if (p.probability > most.probability) most = p;
      }
      EXPECT_NEAR(sum, 1, 1e-5);
      EXPECT_EQ(most.class_id, segment.class_id);
    }
  }
}

TEST(PredictionNoise, LosesTheShareOfStuffThatIsAskedForInPatchesThatStay) {
  PredictionNoise noise;
  noise.stuff_lost = 0.3F;
  const SimulatedFrame f = box_frame(0, kEye);
  const SimulatedFrame later = box_frame(1, kEye);  // the same view, so that pixels are the same places
  double lost = 0;
  double again = 0;
  double stuff = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const Segmentation s = predict_with_noise(noise, seed, f, labels());
    const Segmentation t = predict_with_noise(noise, seed, later, labels());
    for (std::size_t i = 0; i < f.rendering.depth.size(); ++i) {
      if (!labels().is_stuff(f.rendering.class_id[i])) continue;
      stuff += 1;
      lost += s.segment_at[i] == 0 ? 1 : 0;
      again += s.segment_at[i] == 0 && t.segment_at[i] == 0 ? 1 : 0;
    }
  }
  EXPECT_NEAR(lost / stuff, 0.3, 0.07);
  EXPECT_GT(again / lost, 0.55);  // independent frames would give 0.3
}

}  // namespace
}  // namespace panoptic::test
