// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/mapping/tracking_outputs.h"

#include <fmt/format.h>

#include <system_error>
#include <utility>

#include "panoptic/base/files.h"

namespace panoptic {
namespace {

Json to_json(const TrackingSpan& span) {
  Json json = {{"state", to_text(span.state)},
               {"first_frame", span.first_frame},
               {"last_frame", span.last_frame},
               {"frames", span.frames}};
  if (span.state == TrackingState::kLost) {
    json["reason"] = span.reason;
  } else {
    json["least_quality"] = span.least_quality;
  }
  return json;
}

Json loops_json(const std::vector<Loop>& loops) {
  Json list = Json::array();
  for (const Loop& loop : loops) {
    const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> m = loop.earlier_from_frame.matrix();
    list.push_back({{"frame", loop.frame},
                    {"earlier_frame", loop.earlier_frame},
                    {"earlier_from_frame", std::vector<double>(m.data(), m.data() + m.size())},
                    {"moved_m", loop.moved_m},
                    {"is_believed", loop.is_believed},
                    {"corrects", loop.corrects}});
  }
  return {{"loops", std::move(list)}};
}

}  // namespace

Json to_json(const TrackingReport& t) {
  Json json = {{"tracked", t.tracked},           {"lost", t.lost},          {"keyframes", t.keyframes},
               {"mean_quality", t.mean_quality}, {"loops", t.loops.size()}, {"spans", Json::array()}};
  for (const TrackingSpan& span : t.spans) json["spans"].push_back(to_json(span));
  return json;
}

std::string trajectory_text(const std::vector<TimedPose>& trajectory) {
  std::string text = "# time_s x_m y_m z_m qx qy qz qw (world from depth camera)\n";
  for (const TimedPose& pose : trajectory) {
    const Vec3d t = pose.world_from_camera.translation();
    const Eigen::Quaterniond q(pose.world_from_camera.linear());
    text += fmt::format("{:.6f} {:.6f} {:.6f} {:.6f} {:.9f} {:.9f} {:.9f} {:.9f}\n", pose.time_s, t.x(), t.y(), t.z(), q.x(),
                        q.y(), q.z(), q.w());
  }
  return text;
}

void write_tracking(const std::filesystem::path& folder, const std::optional<TrackingReport>& tracking) {
  for (const char* name : {"loops.json", "given_trajectory.txt"}) {  // of an earlier run
    std::error_code ignored;
    std::filesystem::remove(folder / name, ignored);
  }
  if (!tracking) return;
  write_json_file(folder / "loops.json", loops_json(tracking->loops));
  if (tracking->given.empty()) return;
  std::vector<TimedPose> given;
  for (const FramePose& pose : tracking->given) given.push_back({pose.time_s, pose.world_from_camera});
  write_file(folder / "given_trajectory.txt", trajectory_text(given));
}

}  // namespace panoptic
