// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The checks that rest on how well depth images agree: scale, poses, focal length.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "panoptic/io/doctor_checks.h"

namespace panoptic {
namespace {

constexpr double kNearest_m = 0.3;  // where the median depth of a room lies
constexpr double kFarthest_m = 8;
constexpr double kPoorAgreement = 0.5;

struct KnownFactor {
  double factor;
  const char* text;
};
constexpr KnownFactor kKnownFactors[] = {{0.2, "5000 instead of 1000"},
                                         {5, "1000 instead of 5000"},
                                         {1 / 6.5535, "6553.5 instead of 1000"},
                                         {6.5535, "1000 instead of 6553.5"},
                                         {5 / 6.5535, "6553.5 instead of 5000"},
                                         {6.5535 / 5, "5000 instead of 6553.5"},
                                         {0.001, "1000 instead of 1"},
                                         {1000, "1 instead of 1000"},
                                         {4, "256 instead of 1000"}};

std::string factor_remedy(double factor, double scale) {
  std::string text =
      fmt::format("depth is {:.4g} times what it should be: multiply [depth] scale in the calibration file by that", 1 / factor);
  if (scale > 0) {
    text = fmt::format("depth is {:.4g} times what it should be: write [depth] scale = {:g} in the calibration file, not {:g}",
                       1 / factor, scale / factor, scale);
  }
  for (const KnownFactor& known : kKnownFactors) {
    if (std::abs(known.factor / factor - 1) < 0.01) text += fmt::format(" (usually {})", known.text);
  }
  return text;
}

// The divisor that would bring the median into a room.
std::string median_remedy(double median_m, double scale) {
  for (const double factor : {0.2, 1 / 6.5535, 0.001, 5.0, 6.5535, 1000.0}) {
    if (median_m * factor >= kNearest_m && median_m * factor <= kFarthest_m) return factor_remedy(factor, scale);
  }
  return "check [depth] scale in the calibration file (1000 for millimetres, 5000 for TUM, 6553.5 for Replica)";
}

const Hypothesis* best_guess(const Examination& e) {
  return e.found && !e.found->better.empty() ? &e.found->better.front().hypothesis : nullptr;
}

// Depth of a room that has to be multiplied: then it is the translations that are in another unit.
bool is_about_translations(const Hypothesis& h, double median_m) {
  return h.depth_factor != 1 && !is_room(median_m * h.depth_factor);
}

std::string in_words(Hypothesis h, double median_m) {
  if (!is_about_translations(h, median_m)) return in_words(h);
  const std::string translations = fmt::format("translations divided by {:.4g}", h.depth_factor);
  h.depth_factor = 1;
  const std::string rest = in_words(h);
  return rest.empty() ? translations : translations + " and " + rest;
}

// "; with depth times 5, frames agree on 96 % of their points instead of 69 %; as well with ...".
std::string guesses_in_words(const Examination& e) {
  const std::vector<Explanation>& better = e.found->better;
  std::string text =
      fmt::format("; with {}, frames agree on {:.0f} % of their points instead of {:.0f} %",
                  in_words(better.front().hypothesis, e.median_m), 100 * better.front().share, 100 * e.found->declared);
  for (std::size_t i = 1; i < better.size(); ++i) {
    text += fmt::format("{}{}", i == 1 ? "; as well with " : ", or with ", in_words(better[i].hypothesis, e.median_m));
  }
  return text;
}

std::string pose_remedy(const Hypothesis& h, double median_m) {
  if (is_about_translations(h, median_m)) {
    return fmt::format("the translations of the poses are {:.4g} times what they should be ({}): write them in metres",
                       h.depth_factor,
                       h.depth_factor == 1000  ? "millimetres"
                       : h.depth_factor == 100 ? "centimetres"
                                               : "another unit");
  }
  if (h.pose_of != Neighbour::kNone) return "poses and images are shifted by one: check with which numbers they begin";
  if (h.convention.quaternions != QuaternionOrder::kAsRead) {
    return "the four numbers of the quaternions come in another order than they were read in: write the order into a comment "
           "above them ('# tx ty tz qw qx qy qz'), or change it";
  }
  return "poses must take camera coordinates (x right, y down, z forward) to the world: convert them";
}

bool all_poses_equal(const Examination& e) {
  constexpr std::size_t kFewest = 3;
  const FrameFacts* first = nullptr;
  std::size_t equal = 0;
  for (const FrameFacts& frame : e.frames) {
    if (!frame.usable) continue;
    if (first == nullptr) first = &frame;
    if (frame.pose.matrix() != first->pose.matrix()) return false;
    ++equal;
  }
  const bool steps = std::any_of(e.steps.begin(), e.steps.end(), [](const Step& step) { return step.length_m > 0; });
  return equal >= kFewest && !steps;
}

Check check_equal_poses(const Examination& e) {
  const bool images_differ = e.found && e.found->declared < kGoodAgreement;
  Check check{"poses", images_differ || !e.pairs.empty() ? Verdict::kFailed : Verdict::kWarning, "all poses are the same", ""};
  check.evidence += check.verdict == Verdict::kFailed ? ", and the images are not" : ", and so are the images";
  check.remedy = "each image needs the pose of its own moment; a camera that stands still maps what it sees from there";
  return check;
}

}  // namespace

Check check_scale(const Examination& e) {
  constexpr double kNoCamera_m[] = {0.02, 200};
  const bool in_room = e.median_m >= kNearest_m && e.median_m <= kFarthest_m;
  Check check{"depth scale", Verdict::kOk, fmt::format("median depth {:.3g} m", e.median_m), ""};
  const Hypothesis* best = best_guess(e);
  if (e.median_m < kNoCamera_m[0] || e.median_m > kNoCamera_m[1]) {
    check.verdict = Verdict::kImpossible;
    check.remedy = median_remedy(e.median_m, e.notes.depth_scale);
  } else if (best != nullptr && best->along_ray) {
    check.verdict = Verdict::kFailed;
    check.evidence += guesses_in_words(e);
    check.remedy =
        "the images hold the distance from the camera's centre: divide it by the length of ((u - cx) / fx, (v - cy) / fy, 1) to "
        "get the distance along its axis";
  } else if (best != nullptr && best->depth_factor != 1 && !is_about_translations(*best, e.median_m)) {
    check.verdict = Verdict::kFailed;
    check.evidence += guesses_in_words(e);
    check.remedy = factor_remedy(best->depth_factor, e.notes.depth_scale);
  } else if (!in_room) {
    // Poses that fit the depth say that both are in the same unit: an unusual scene rather than a wrong scale.
    const bool poses_fit = e.found && e.found->declared >= kGoodAgreement;
    check.verdict = poses_fit ? Verdict::kWarning : Verdict::kFailed;
    check.remedy = median_remedy(e.median_m, e.notes.depth_scale);
  }
  return check;
}

Check check_poses(const Examination& e) {
  if (all_poses_equal(e)) return check_equal_poses(e);
  Check check{"poses", Verdict::kOk, "", ""};
  if (!e.found) {
    check.verdict = Verdict::kWarning;
    check.evidence = "too little motion that can be seen in the depth images to tell pose direction and axes";
    check.remedy = "look at the map after a short run";
    return check;
  }
  check.evidence = fmt::format("in {} pairs of frames, {:.0f} % of the points agree under the declared poses", e.pairs.size(),
                               100 * e.found->declared);
  const Hypothesis* best = best_guess(e);
  const bool about_poses = best != nullptr && (!best->convention.is_declared() || best->pose_of != Neighbour::kNone ||
                                               is_about_translations(*best, e.median_m));
  if (about_poses) {
    check.verdict = Verdict::kFailed;
    check.evidence += guesses_in_words(e);
    check.remedy = pose_remedy(*best, e.median_m);
  } else if (e.found->declared < kGoodAgreement && best == nullptr) {
    check.verdict = e.found->declared < kPoorAgreement ? Verdict::kFailed : Verdict::kWarning;
    check.evidence += ", and no other direction, axes or scale explains them";
    check.remedy = "check the intrinsics, and that every pose belongs to its image (order, time stamps)";
    if (e.found->without_translation >= kGoodAgreement) {
      check.evidence += fmt::format("; with their rotations alone {:.0f} % agree", 100 * e.found->without_translation);
      check.remedy = "the translations are wrong, or in another unit: write them in metres";
    }
  }
  return check;
}

void add_focal_finding(Check& intrinsics, const Examination& e) {
  const Hypothesis* best = best_guess(e);
  if (best == nullptr || best->focal_factor == 1 || intrinsics.verdict >= Verdict::kFailed) return;
  intrinsics.verdict = Verdict::kFailed;
  intrinsics.evidence += guesses_in_words(e);
  intrinsics.remedy = "the focal lengths are those of another camera or image size: give the right ones in the calibration file";
}

}  // namespace panoptic
