// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/doctor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "panoptic/io/doctor_geometry.h"
#include "panoptic/io/doctor_sample.h"

namespace panoptic {
namespace {

constexpr double kNearest_m = 0.3;  // where the median depth of a room lies
constexpr double kFarthest_m = 8;
constexpr double kLongestStep_m = 0.5;
constexpr double kGoodAgreement = 0.7;
constexpr double kPoorAgreement = 0.5;
constexpr std::size_t kFewestPairs = 3;

Check check_frames(const std::vector<FrameFacts>& frames, std::size_t size) {
  std::map<std::string, std::size_t> reasons;
  std::size_t dropped = 0;
  for (const FrameFacts& frame : frames) {
    if (frame.usable) continue;
    ++dropped;
    ++reasons[frame.reason.substr(0, frame.reason.find(':'))];  // without the file's name
  }
  Check check{"frames", Verdict::kOk, fmt::format("{} of {} frames looked at, {} cannot be used", frames.size(), size, dropped),
              ""};
  for (const auto& [reason, count] : reasons) check.evidence += fmt::format("; {} x {}", count, reason);
  if (dropped == 0 && !frames.empty()) return check;
  check.verdict = 2 * dropped >= frames.size() ? Verdict::kFailed : Verdict::kWarning;
  check.remedy = "frames that cannot be used are skipped; check the files and poses named above if there are many";
  return check;
}

Check check_rotations(const std::vector<FrameFacts>& frames) {
  std::size_t usable = 0;
  std::size_t bad = 0;
  for (const FrameFacts& frame : frames) {
    usable += frame.usable ? 1 : 0;
    bad += (frame.usable && !frame.rigid) || frame.reason == "pose is not a rigid transform" ? 1 : 0;
  }
  Check check{"rotations", Verdict::kOk,
              fmt::format("{} of {} poses are not rotations (orthonormal, determinant +1)", bad, usable + bad), ""};
  if (bad == 0) return check;
  check.verdict = 2 * bad >= usable + bad ? Verdict::kFailed : Verdict::kWarning;
  check.remedy = "store poses as 4x4 matrices row by row with a rotation in the upper left; quaternions must have length 1";
  return check;
}

Check check_steps(const std::vector<PairFacts>& pairs) {
  std::vector<float> steps;
  for (const PairFacts& facts : pairs) {
    if (facts.step_m) steps.push_back(static_cast<float>(*facts.step_m));
  }
  const auto too_long = std::count_if(steps.begin(), steps.end(), [](float s) { return s > static_cast<float>(kLongestStep_m); });
  const double longest = steps.empty() ? 0 : static_cast<double>(*std::max_element(steps.begin(), steps.end()));
  Check check{"steps", Verdict::kOk,
              fmt::format("from frame to frame the camera moves {:.3f} m (median), {:.3f} m at most", median(steps), longest),
              ""};
  if (10 * static_cast<std::size_t>(too_long) <= steps.size()) return check;
  check.verdict = Verdict::kWarning;
  check.remedy = "are the translations in metres, and is every frame there? Tracking needs overlapping views";
  return check;
}

Check check_intrinsics(const std::string& name, const Camera& camera) {
  constexpr double kNarrowest_deg = 30;
  constexpr double kWidest_deg = 120;
  const double view_deg = 2 * std::atan(camera.width / (2 * repaired(camera).fx)) * 180 / std::numbers::pi;
  Check check{name, Verdict::kOk,
              fmt::format("principal point {:.1f}, {:.1f} in {}x{} images, field of view {:.0f} degrees", camera.cx, camera.cy,
                          camera.width, camera.height, view_deg),
              ""};
  if (const auto size = other_size(camera)) {
    check.verdict = Verdict::kFailed;
    check.remedy = fmt::format(
        "the intrinsics speak of images of about {}x{}; give those of this size, or name their size as "
        "width and height in the calibration file and they are scaled",
        size->width, size->height);
  } else if (view_deg < kNarrowest_deg || view_deg > kWidest_deg) {
    check.verdict = Verdict::kFailed;
    check.remedy = "the focal length does not fit the width of the images; check fx and fy (in pixels)";
  }
  return check;
}

std::string factor_remedy(double factor) {
  struct Known {
    double factor;
    const char* text;
  };
  constexpr Known kKnown[] = {{0.2, "5000 instead of 1000"},          {5, "1000 instead of 5000"},
                              {1 / 6.5535, "6553.5 instead of 1000"}, {6.5535, "1000 instead of 6553.5"},
                              {5 / 6.5535, "6553.5 instead of 5000"}, {6.5535 / 5, "5000 instead of 6553.5"},
                              {0.001, "1000 instead of 1"},           {1000, "1 instead of 1000, or poses in millimetres"}};
  std::string text =
      fmt::format("depth is {:.3g} times what it should be: multiply [depth] scale in the calibration file by that", 1 / factor);
  for (const Known& known : kKnown) {
    if (std::abs(known.factor / factor - 1) < 0.01) text += fmt::format(" (usually {})", known.text);
  }
  return text;
}

// The divisor that would bring the median into a room.
std::string median_remedy(double median_m) {
  for (const double factor : {0.2, 1 / 6.5535, 0.001, 5.0, 6.5535, 1000.0}) {
    if (median_m * factor >= kNearest_m && median_m * factor <= kFarthest_m) return factor_remedy(factor);
  }
  return "check [depth] scale in the calibration file (1000 for millimetres, 5000 for TUM, 6553.5 for Replica)";
}

// Findings about scale, poses and focal length from the agreement of depth images.
struct Geometry {
  std::size_t pairs = 0;
  Explanations found;
  bool factor = false;  // each true if that guess explains the depth clearly better than what is declared
  bool convention = false;
  bool focal = false;
  Hypothesis best;
  double best_share = 0;
};

Geometry judge(const std::vector<ViewPair>& pairs) {
  Geometry g{pairs.size(), explain(pairs), false, false, false, {}, 0};
  const Explanations& e = g.found;
  const Explanation* best = &e.depth_factor;
  if (e.convention.share > best->share) best = &e.convention;
  if (e.focal_factor.share > best->share) best = &e.focal_factor;
  if (clearly_better(best->share, e.both.share)) best = &e.both;
  g.best = best->hypothesis;
  g.best_share = best->share;
  if (best->share < kGoodAgreement || !clearly_better(e.declared, best->share)) return g;
  g.factor = g.best.depth_factor != 1;
  g.focal = g.best.focal_factor != 1;
  g.convention =
      best == &e.convention || (best == &e.both && (g.best.convention.inverse || !g.best.convention.axes.isIdentity()));
  return g;
}

Check check_scale(const std::vector<FrameFacts>& frames, const std::optional<Geometry>& geometry) {
  std::vector<float> medians;
  for (const FrameFacts& frame : frames) {
    if (frame.median_m > 0) medians.push_back(static_cast<float>(frame.median_m));
  }
  const double median_m = median(medians);
  const bool in_room = median_m >= kNearest_m && median_m <= kFarthest_m;
  Check check{"depth scale", Verdict::kOk, fmt::format("median depth {:.3g} m", median_m), ""};
  if (geometry && geometry->factor) {
    check.verdict = Verdict::kFailed;
    check.evidence += fmt::format("; with depth times {:.3g}, frames agree on {:.0f} % of their points instead of {:.0f} %",
                                  geometry->best.depth_factor, 100 * geometry->best_share, 100 * geometry->found.declared);
    check.remedy = factor_remedy(geometry->best.depth_factor);
  } else if (!in_room) {
    // Poses that fit the depth say that both are in the same unit: an unusual scene rather than a wrong scale.
    const bool poses_fit = geometry && geometry->found.declared >= kGoodAgreement;
    check.verdict = poses_fit ? Verdict::kWarning : Verdict::kFailed;
    check.remedy = median_remedy(median_m);
  }
  return check;
}

Check check_poses(const std::optional<Geometry>& geometry) {
  Check check{"poses", Verdict::kOk, "", ""};
  if (!geometry) {
    check.verdict = Verdict::kWarning;
    check.evidence = "too little motion that can be seen in the depth images to tell pose direction and axes";
    check.remedy = "look at the map after a short run";
    return check;
  }
  const Geometry& g = *geometry;
  check.evidence = fmt::format("in {} pairs of frames, {:.0f} % of the points agree under the declared poses", g.pairs,
                               100 * g.found.declared);
  if (g.convention) {
    check.verdict = Verdict::kFailed;
    check.evidence += fmt::format(", {:.0f} % if the poses are {}", 100 * g.best_share, g.best.convention.name);
    check.remedy = "poses must take camera coordinates (x right, y down, z forward) to the world: convert them";
  } else if (g.found.declared < kGoodAgreement && !g.factor && !g.focal) {
    check.verdict = g.found.declared < kPoorAgreement ? Verdict::kFailed : Verdict::kWarning;
    check.evidence += ", and no other direction, axes or scale explains them";
    check.remedy = "check the intrinsics, and that every pose belongs to its image (order, time stamps)";
  }
  return check;
}

void add_focal_finding(Check& intrinsics, const std::optional<Geometry>& geometry) {
  if (!geometry || !geometry->focal || intrinsics.verdict == Verdict::kFailed) return;
  intrinsics.verdict = Verdict::kFailed;
  intrinsics.evidence +=
      fmt::format("; with focal lengths times {:.3g}, frames agree on {:.0f} % of their points instead of {:.0f} %",
                  geometry->best.focal_factor, 100 * geometry->best_share, 100 * geometry->found.declared);
  intrinsics.remedy = "the focal lengths are those of another camera or image size: give the right ones in the calibration file";
}

}  // namespace

Verdict DoctorReport::worst() const {
  Verdict worst = Verdict::kOk;
  for (const Check& check : checks) worst = std::max(worst, check.verdict);
  return worst;
}

DoctorReport diagnose(const Dataset& dataset, const DoctorOptions& options) {
  const std::vector<FrameFacts> frames = examine_frames(dataset, options.frames);
  DoctorReport report{{check_frames(frames, dataset.size()), check_rotations(frames)}};
  const auto usable = std::find_if(frames.begin(), frames.end(), [](const FrameFacts& frame) { return frame.usable; });
  if (usable == frames.end()) return report;

  std::vector<PairFacts> pair_facts = find_pairs(dataset, options.pairs);
  std::vector<ViewPair> pairs;
  for (PairFacts& facts : pair_facts) {
    if (facts.pair) pairs.push_back(std::move(*facts.pair));
  }
  const std::optional<Geometry> geometry = pairs.size() < kFewestPairs ? std::nullopt : std::optional(judge(pairs));

  Check intrinsics = check_intrinsics("depth intrinsics", usable->depth_camera);
  add_focal_finding(intrinsics, geometry);
  report.checks.push_back(std::move(intrinsics));
  report.checks.push_back(check_intrinsics("colour intrinsics", usable->color_camera));
  report.checks.push_back(check_scale(frames, geometry));
  report.checks.push_back(check_poses(geometry));
  report.checks.push_back(check_steps(pair_facts));
  return report;
}

std::string to_text(const DoctorReport& report) {
  const auto word = [](Verdict verdict) {
    return verdict == Verdict::kOk ? "ok" : verdict == Verdict::kWarning ? "warning" : "FAILED";
  };
  std::string text;
  for (const Check& check : report.checks) {
    text += fmt::format("{:<8} {:<17} {}\n", word(check.verdict), check.name, check.evidence);
    if (!check.remedy.empty()) text += fmt::format("{:<26} -> {}\n", "", check.remedy);
  }
  return text;
}

}  // namespace panoptic
