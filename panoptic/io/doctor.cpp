// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/doctor.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "panoptic/base/text.h"
#include "panoptic/io/doctor_checks.h"
#include "panoptic/io/doctor_drift.h"
#include "panoptic/io/doctor_list.h"

namespace panoptic {
namespace {

constexpr std::size_t kFewestPairs = 3;

const char* word(Verdict verdict) {
  switch (verdict) {
    case Verdict::kOk:
      return "ok";
    case Verdict::kAssumed:
      return "assumed";
    case Verdict::kWarning:
      return "warning";
    case Verdict::kFailed:
      return "FAILED";
    case Verdict::kImpossible:
      break;
  }
  return "REFUSED";
}

double median_depth_m(const std::vector<FrameFacts>& frames) {
  std::vector<float> medians;
  for (const FrameFacts& frame : frames) {
    if (frame.median_m > 0) medians.push_back(static_cast<float>(frame.median_m));
  }
  return median(std::move(medians));
}

// Puts first those guesses, of some that noise cannot tell apart, that make the scale one that programs write: metres, 256 or 512
// parts of one, millimetres, their quarters and tenths, TUM's and Replica's.
void put_usual_scales_first(std::vector<Explanation>& guesses, double scale) {
  constexpr std::array<double, 8> kUsual = {1, 256, 512, 1000, 4000, 5000, 6553.5, 10000};
  constexpr double kSame = 1e-3;
  const auto is_usual = [&](const Explanation& guess) {
    if (guess.hypothesis.depth_factor == 1) return true;
    const double right = scale / guess.hypothesis.depth_factor;
    return std::any_of(kUsual.begin(), kUsual.end(), [&](double usual) { return std::abs(right / usual - 1) < kSame; });
  };
  if (scale > 0) std::stable_partition(guesses.begin(), guesses.end(), is_usual);
}

// Adds what takes pairs of frames to know.
void compare_frames(Examination& e, const Dataset& dataset, const DoctorOptions& options) {
  std::vector<PairFacts> pairs = find_pairs(dataset, options.pairs);
  const bool knows_poses = !e.steps.empty();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (pairs[i].step_m && !knows_poses) e.steps.push_back({i * dataset.size() / pairs.size(), *pairs[i].step_m});
    if (pairs[i].pair) e.pairs.push_back(std::move(*pairs[i].pair));
  }
  if (e.pairs.size() < kFewestPairs) return;
  e.found = explain(e.pairs, e.median_m);
  put_usual_scales_first(e.found->better, e.notes.depth_scale);
}

void add_notes(DoctorReport& report, const RecordingNotes& notes) {
  for (const std::string& line : notes.assumed) report.checks.push_back({"recording", Verdict::kAssumed, line, ""});
  for (const std::string& line : notes.left_out) report.checks.push_back({"left out", Verdict::kAssumed, line, ""});
}

}  // namespace

Verdict DoctorReport::worst() const {
  Verdict worst = Verdict::kOk;
  for (const Check& check : checks) worst = std::max(worst, check.verdict);
  return worst;
}

std::size_t DoctorReport::count(Verdict at_least) const {
  return static_cast<std::size_t>(
      std::count_if(checks.begin(), checks.end(), [&](const Check& check) { return check.verdict >= at_least; }));
}

DoctorReport diagnose(const Dataset& dataset, const DoctorOptions& options) {
  if (const RecordingList* list = as_recording_list(dataset)) return diagnose_list(*list, options);
  Examination e{dataset.notes(), dataset.size(), examine_frames(dataset, options.frames), {}, {}, 0, {}};
  DoctorReport report{{check_frames(e), check_rotations(e)}};
  add_notes(report, e.notes);
  const auto read = std::find_if(e.frames.begin(), e.frames.end(), [](const FrameFacts& f) { return f.depth_camera.width > 0; });
  if (read == e.frames.end()) return report;
  Check of_depth = check_intrinsics("depth intrinsics", read->depth_camera);
  Check of_color = check_intrinsics("colour intrinsics", read->color_camera);

  e.median_m = median_depth_m(e.frames);
  const bool is_usable = e.median_m > 0 && std::max(of_depth.verdict, of_color.verdict) < Verdict::kImpossible;
  if (is_usable) {
    e.steps = find_steps(dataset, options.steps);
    compare_frames(e, dataset, options);
    add_focal_finding(of_depth, e);
  }
  report.checks.push_back(std::move(of_depth));
  report.checks.push_back(std::move(of_color));
  if (!is_usable) return report;
  report.checks.push_back(check_readings(e));
  report.checks.push_back(check_scale(e));
  report.checks.push_back(check_poses(e));
  report.checks.push_back(check_steps(e));
  const bool fits = report.worst() < Verdict::kFailed;
  if (options.revisits > 0 && fits) report.checks.push_back(check_drift(find_revisits(dataset, options.revisits)));
  return report;
}

std::string to_text(const DoctorReport& report) {
  std::string text;
  for (const Check& check : report.checks) {
    text += fmt::format("{:<8} {:<17} {}\n", word(check.verdict), check.name, check.evidence);
    if (!check.remedy.empty()) text += fmt::format("{:<26} -> {}\n", "", check.remedy);
  }
  return text;
}

Json to_json(const DoctorReport& report) {
  Json checks = Json::array();
  for (const Check& check : report.checks) {
    checks.push_back({{"name", check.name},
                      {"verdict", lower_case(word(check.verdict))},
                      {"evidence", check.evidence},
                      {"remedy", check.remedy}});
  }
  return {{"checks", std::move(checks)}};
}

}  // namespace panoptic
