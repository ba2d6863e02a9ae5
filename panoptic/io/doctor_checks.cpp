// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/doctor_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace panoptic {
namespace {

double view_deg(const Camera& camera) { return 2 * std::atan(camera.width / (2 * camera.fx)) * 180 / std::numbers::pi; }

// True for numbers that no pinhole camera has: a view of more than 150 degrees, or of less than 3; one that is far from as high
// as it is wide.
bool is_no_focal_length(const Camera& camera) {
  constexpr double kWidest_deg = 150;
  constexpr double kNarrowest_deg = 3;
  constexpr double kFlattest = 4;  // of one focal length to the other
  const double ratio = camera.fx / camera.fy;
  return view_deg(camera) > kWidest_deg || view_deg(camera) < kNarrowest_deg || ratio > kFlattest || ratio < 1 / kFlattest;
}

std::string focal_remedy(const Camera& camera) {
  constexpr double kLargestShare = 10;
  constexpr double kLongest_mm = 100;
  if (camera.fx < kLargestShare && std::abs(camera.cx) <= 1 && std::abs(camera.cy) <= 1) {
    return fmt::format("intrinsics are in pixels: multiply fx and cx by {}, fy and cy by {}", camera.width, camera.height);
  }
  if (camera.fx < kLongest_mm) {
    return "intrinsics are in pixels: multiply millimetres by the width of the image in pixels / that of the sensor in "
           "millimetres";
  }
  return "intrinsics are in pixels, fx 0 cx, 0 fy cy, 0 0 1 row by row: check the file that gives them";
}

bool is_outside(const Camera& camera) {
  return camera.cx <= 0 || camera.cy <= 0 || camera.cx >= camera.width - 1 || camera.cy >= camera.height - 1;
}

// The order in which four numbers make sense that make none as fx fy cx cy; nothing if there is none.
std::string order_of_intrinsics(const Camera& c) {
  const auto is_sensible = [&](double fx, double fy, double cx, double cy) {
    const Camera other{c.width, c.height, fx, fy, cx, cy};
    return !other_size(other) && !is_no_focal_length(other) && std::abs(fx / fy - 1) < 0.2;
  };
  if (is_sensible(c.cx, c.cy, c.fx, c.fy)) return "cx cy fx fy";
  if (is_sensible(c.fx, c.cx, c.fy, c.cy)) return "fx cx fy cy";
  return {};
}

std::string size_remedy(const Camera& camera, ImageSize size) {
  if (const std::string order = order_of_intrinsics(camera); !order.empty())
    return fmt::format("the numbers look like {}: write them as fx fy cx cy", order);
  if (size.width <= 1 || size.height <= 1) {
    return "the principal point lies near the middle of an image: is the matrix written column by column, or not in pixels?";
  }
  return fmt::format(
      "the intrinsics speak of images of about {}x{}; give those of this size (times {:.4g}, {:.4g}), or name their size as "
      "width "
      "and height in the calibration file and they are scaled",
      size.width, size.height, static_cast<double>(camera.width) / size.width, static_cast<double>(camera.height) / size.height);
}

// A value that a tenth of all readings have, and one in a hundred of the readings of at least half of the frames: no wall is that
// far from everywhere.
struct SharedValue {
  float depth_m = 0;
  double share = 0;
};

std::optional<SharedValue> shared_value(const std::vector<FrameFacts>& frames) {
  constexpr double kLeastShare = 0.1;
  constexpr std::size_t kFewestFrames = 3;
  struct Tally {
    std::size_t readings = 0;
    std::size_t frames = 0;
  };
  std::map<float, Tally> tallies;
  std::size_t readings = 0;
  std::size_t usable = 0;
  for (const FrameFacts& frame : frames) {
    if (!frame.usable) continue;
    ++usable;
    readings += frame.readings;
    for (const auto& [depth_m, count] : frame.common_m) {
      tallies[depth_m].readings += count;
      ++tallies[depth_m].frames;
    }
  }
  std::optional<SharedValue> most;
  for (const auto& [depth_m, tally] : tallies) {
    const double share = static_cast<double>(tally.readings) / static_cast<double>(std::max<std::size_t>(readings, 1));
    if (share < kLeastShare || 2 * tally.frames < usable || tally.frames < kFewestFrames) continue;
    if (!most || share > most->share) most = SharedValue{depth_m, share};
  }
  return most;
}

}  // namespace

Check check_frames(const Examination& e) {
  std::map<std::string, std::size_t> reasons;
  std::size_t dropped = 0;
  std::size_t without_pose = 0;
  for (const FrameFacts& frame : e.frames) {
    if (frame.usable) continue;
    ++dropped;
    without_pose += frame.reason.starts_with("pose missing") ? 1 : 0;
    ++reasons[frame.reason.substr(0, frame.reason.find(':'))];  // without the file's name
  }
  Check check{"frames", Verdict::kOk,
              fmt::format("{} of {} frames looked at, {} cannot be used", e.frames.size(), e.size, dropped), ""};
  for (const auto& [reason, count] : reasons) check.evidence += fmt::format("; {} x {}", count, reason);
  if (dropped == 0 && !e.frames.empty()) return check;
  check.verdict = 2 * dropped >= e.frames.size() ? Verdict::kFailed : Verdict::kWarning;
  const bool no_poses = without_pose > 0 && without_pose == dropped && dropped == e.frames.size();
  check.remedy =
      no_poses ? "the recording has no poses, and mapping needs one for each frame: add those of a tracker or of a SLAM system"
               : "frames that cannot be used are skipped; check the files and poses named above if there are many";
  return check;
}

Check check_rotations(const Examination& e) {
  std::size_t usable = 0;
  std::size_t bad = 0;
  for (const FrameFacts& frame : e.frames) {
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

Check check_intrinsics(const std::string& name, const Camera& camera) {
  constexpr double kNarrowest_deg = 30;
  constexpr double kWidest_deg = 120;
  if (is_no_focal_length(camera)) {
    return {name, Verdict::kImpossible,
            fmt::format("fx = {:.4g}, fy = {:.4g} pixels for images {}x{}", camera.fx, camera.fy, camera.width, camera.height),
            focal_remedy(camera)};
  }
  const double degrees = view_deg(repaired(camera));
  Check check{name, Verdict::kOk,
              fmt::format("principal point {:.1f}, {:.1f} in {}x{} images, field of view {:.0f} degrees", camera.cx, camera.cy,
                          camera.width, camera.height, degrees),
              ""};
  if (const auto size = other_size(camera)) {
    check.verdict = is_outside(camera) ? Verdict::kImpossible : Verdict::kFailed;
    check.remedy = size_remedy(camera, *size);
  } else if (degrees < kNarrowest_deg || degrees > kWidest_deg) {
    check.verdict = Verdict::kFailed;
    check.remedy = "the focal length does not fit the width of the images; check fx and fy (in pixels)";
  }
  return check;
}

Check check_readings(const Examination& e) {
  const double scale = e.notes.depth_scale;
  Check check{"depth readings", Verdict::kOk, "no value that stands out among the readings", ""};
  const auto shared = shared_value(e.frames);
  if (!shared) return check;
  check.verdict = Verdict::kFailed;
  const double depth_m = static_cast<double>(shared->depth_m);
  check.evidence = fmt::format("{:.0f} % of all readings are exactly {:.4g} m", 100 * shared->share, depth_m);
  const std::string raw = scale > 0 ? fmt::format("{:.0f}", depth_m * scale) : "that value";
  check.remedy = fmt::format("if it stands for no reading, write [depth] invalid = [{}] in the calibration file", raw);
  return check;
}

Check check_steps(const Examination& e) {
  constexpr double kLong_m = 0.5;
  constexpr double kJump = 10;  // times the usual step
  std::vector<float> lengths;
  for (const Step& step : e.steps) lengths.push_back(static_cast<float>(step.length_m));
  const double usual_m = median(lengths);
  const auto longer_than = [&](double m) {
    return std::count_if(e.steps.begin(), e.steps.end(), [m](const Step& step) { return step.length_m > m; });
  };
  const auto longest =
      std::max_element(e.steps.begin(), e.steps.end(), [](const Step& a, const Step& b) { return a.length_m < b.length_m; });
  Check check{"steps", Verdict::kOk,
              fmt::format("from frame to frame the camera moves {:.3f} m (median), {:.3f} m at most", usual_m,
                          e.steps.empty() ? 0 : longest->length_m),
              ""};
  if (const auto jumps = longer_than(std::max(kLong_m, kJump * usual_m)); jumps > 0) {
    check.verdict = Verdict::kWarning;
    check.evidence +=
        fmt::format(", from position {} to the next; {} such {}", longest->position, jumps, jumps == 1 ? "jump" : "jumps");
    check.remedy = "did tracking jump there? What follows lies beside what was before: leave it out with --frames A:B";
  } else if (10 * static_cast<std::size_t>(longer_than(kLong_m)) > e.steps.size()) {
    check.verdict = Verdict::kWarning;
    check.remedy = "are the translations in metres, and is every frame there? Tracking needs overlapping views";
  }
  return check;
}

}  // namespace panoptic
