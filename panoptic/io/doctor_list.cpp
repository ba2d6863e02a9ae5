// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/doctor_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace panoptic {
namespace {

constexpr std::size_t kPoses = 300;  // looked at in each recording,
constexpr std::size_t kImages = 12;  // or frames, where no pose is known without its images
// Cameras look down and aside, so that the means of honest recordings differ; axes that were mixed up differ by 90 or 180.
constexpr double kWidest_deg = 60;

// The upward direction in the common world, as Mapper::up has it: the mean of the cameras' -y axes. Zero if no frame has a pose.
Vec3d up_of(const RecordingList& list, const RecordingList::Part& part) {
  const std::size_t frames = part.dataset->size();
  Vec3d sum = Vec3d::Zero();
  const auto add = [&](const std::optional<Pose>& pose) {
    if (pose && is_finite(*pose)) sum -= pose->linear().col(1);
  };
  const std::size_t poses = std::min(kPoses, frames);
  for (std::size_t i = 0; i < poses; ++i) add(list.pose(part.first_position + i * frames / poses));
  const std::size_t images = sum.isZero() ? std::min(kImages, frames) : 0;
  for (std::size_t i = 0; i < images; ++i) {
    const ReadResult read = list.read(part.first_position + i * frames / images);
    if (read.frame) add(read.frame->world_from_camera);
  }
  return sum;
}

double angle_deg(const Vec3d& a, const Vec3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::numbers::pi; }

Check check_up(const RecordingList& list) {
  const Vec3d first = up_of(list, list.parts().front());
  Check check{"up", Verdict::kOk, "", ""};
  double widest_deg = 0;
  const RecordingList::Part* differs = nullptr;
  for (const RecordingList::Part& part : list.parts()) {
    const double apart_deg = angle_deg(first, up_of(list, part));
    if (apart_deg <= widest_deg) continue;
    widest_deg = apart_deg;
    differs = &part;
  }
  if (widest_deg <= kWidest_deg || differs == nullptr) {
    check.evidence = fmt::format("the recordings' upward directions are within {:.0f} degrees of the first one's", widest_deg);
    return check;
  }
  check.verdict = Verdict::kImpossible;
  check.evidence = fmt::format("{}: its upward direction (the cameras' mean -y axis) is {:.0f} degrees from that of {}",
                               differs->listed.name, widest_deg, list.parts().front().listed.name);
  check.remedy = "give it the rotation in the list that sets it upright beside the others";
  return check;
}

}  // namespace

DoctorReport diagnose_list(const RecordingList& list, const DoctorOptions& options) {
  DoctorReport report;
  for (const RecordingList::Part& part : list.parts()) {
    for (Check& check : diagnose(*part.dataset, options).checks) {
      check.evidence = fmt::format("{}: {}", part.listed.name, check.evidence);
      report.checks.push_back(std::move(check));
    }
  }
  report.checks.push_back(check_up(list));
  return report;
}

}  // namespace panoptic
