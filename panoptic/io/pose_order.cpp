// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/pose_order.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "panoptic/error.h"
#include "panoptic/io/dataset_frame.h"
#include "panoptic/io/doctor_geometry.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr std::size_t kOrders = 2;
constexpr std::size_t kNumeric = 0;
constexpr std::size_t kText = 1;

// From one image to the next by number, with the poses that either order gives the two.
struct ImageStep {
  std::size_t from = 0;  // positions
  std::size_t to = 0;
  std::array<Pose, kOrders> first;
  std::array<Pose, kOrders> second;

  Pose motion(std::size_t order) const { return first.at(order).inverse() * second.at(order); }
};

using Poses = std::array<Pose, kOrders>;

std::optional<Poses> poses_of(const FileRecording& recording, std::size_t position) {
  Poses poses;
  const std::array<std::optional<Eigen::Matrix4d>, kOrders> stored = {recording.frames[position].pose,
                                                                      recording.other_order.poses[position]};
  for (std::size_t order = 0; order < kOrders; ++order) {
    if (!stored.at(order) || !check_pose(*stored.at(order)).used) return std::nullopt;
    poses.at(order) = camera_pose(*stored.at(order), recording.calibration);
  }
  return poses;
}

// The steps in which the two orders differ: the others prove nothing.
std::vector<ImageStep> differing_steps(const FileRecording& recording) {
  std::vector<ImageStep> steps;
  std::optional<Poses> before;
  std::size_t from = 0;
  for (std::size_t position = 0; position < recording.frames.size(); ++position) {
    const std::optional<Poses> poses = poses_of(recording, position);
    if (!poses) continue;
    if (before) {
      ImageStep step{from, position, *before, *poses};
      if (!step.motion(kNumeric).isApprox(step.motion(kText), 1e-6)) steps.push_back(std::move(step));
    }
    before = poses;
    from = position;
  }
  return steps;
}

// How well the depth images of a sample of steps agree under the poses of either order; nothing if too few can be compared.
std::optional<std::array<double, kOrders>> agreements(const FileRecording& recording, const std::vector<ImageStep>& steps) {
  constexpr std::size_t kSample = 16;
  constexpr std::size_t kFewest = 2;
  const FileDataset dataset(recording);
  std::vector<std::optional<ViewPair>> read(std::min(kSample, steps.size()));
  const auto step_of = [&](std::size_t i) -> const ImageStep& { return steps[i * steps.size() / read.size()]; };
  parallel_for(read.size(), [&](std::size_t i) {
    const ImageStep& step = step_of(i);
    const ReadResult from = dataset.read(step.from);
    const ReadResult to = dataset.read(step.to);
    if (!from.frame || !to.frame) return;
    read[i] = ViewPair{thinned(*from.frame, from.frame->depth_camera), thinned(*to.frame, to.frame->depth_camera)};
  });
  std::array<double, kOrders> result{};
  for (std::size_t order = 0; order < kOrders; ++order) {
    std::vector<ViewPair> pairs;
    for (std::size_t i = 0; i < read.size(); ++i) {
      if (!read[i]) continue;
      ViewPair& pair = pairs.emplace_back(*read[i]);
      pair.from.pose = step_of(i).first.at(order);
      pair.to.pose = step_of(i).second.at(order);
    }
    if (pairs.size() < kFewest) return std::nullopt;
    result.at(order) = agreement(pairs, {});
  }
  return result;
}

// The share that either order has of all motion in the differing steps, of translation and of rotation alike.
std::array<double, kOrders> shares_of_motion(const std::vector<ImageStep>& steps) {
  std::array<double, kOrders> metres{};
  std::array<double, kOrders> radians{};
  for (const ImageStep& step : steps) {
    for (std::size_t order = 0; order < kOrders; ++order) {
      const Pose motion = step.motion(order);
      metres.at(order) += motion.translation().norm();
      radians.at(order) += Eigen::AngleAxisd(motion.linear()).angle();
    }
  }
  const auto share = [](double part, double whole) { return whole > 0 ? part / whole : 0; };
  std::array<double, kOrders> result{};
  for (std::size_t order = 0; order < kOrders; ++order) {
    result.at(order) = share(metres.at(order), metres[0] + metres[1]) + share(radians.at(order), radians[0] + radians[1]);
  }
  return result;
}

struct Decision {
  std::size_t order = kNumeric;
  std::string reason;
};

std::optional<Decision> by_depth(const std::array<double, kOrders>& agreements) {
  const std::size_t best = agreements[kText] > agreements[kNumeric] ? kText : kNumeric;
  const double other = agreements.at(1 - best);
  if (agreements.at(best) < kGoodAgreement || !clearly_better(other, agreements.at(best))) return std::nullopt;
  return Decision{best, fmt::format("neighbouring depth images then agree on {:.0f} % of their points instead of {:.0f} %",
                                    100 * agreements.at(best), 100 * other)};
}

std::optional<Decision> by_motion(const std::vector<ImageStep>& steps) {
  constexpr double kClearly = 0.5;
  const std::array<double, kOrders> motion = shares_of_motion(steps);
  const std::size_t best = motion[kText] < motion[kNumeric] ? kText : kNumeric;
  const double ratio = motion.at(best) / std::max(motion.at(1 - best), 1e-12);
  if (ratio > kClearly) return std::nullopt;
  return Decision{best, fmt::format("the camera then moves {:.0f} % of what the other order makes it", 100 * ratio)};
}

}  // namespace

void settle_pose_order(FileRecording& recording) {
  if (recording.other_order.poses.empty()) return;
  const std::vector<ImageStep> steps = differing_steps(recording);
  if (steps.empty()) return;
  const auto shares = agreements(recording, steps);
  std::optional<Decision> decision = shares ? by_depth(*shares) : std::nullopt;
  if (!decision) decision = by_motion(steps);
  if (!decision) {
    throw Error(fmt::format(
        "{}: is line 3 of the image numbered 2 (1, 2, 10) or of the third name as text (1, 10, 2)? Neither order of the "
        "poses fits the depth images clearly better; write the image's name before each pose, or give all names as "
        "many digits",
        (recording.root / recording.other_order.list).string()));
  }
  const bool by_text = decision->order == kText;
  if (by_text) {
    for (std::size_t i = 0; i < recording.frames.size(); ++i) recording.frames[i].pose = recording.other_order.poses[i];
  }
  recording.assumed.push_back(fmt::format("{}: its poses are in the order of the images' {}, not of their {}: {}",
                                          recording.other_order.list, by_text ? "names as text (1, 10, 2)" : "numbers (1, 2, 10)",
                                          by_text ? "numbers (1, 2, 10)" : "names as text (1, 10, 2)", decision->reason));
  recording.other_order = {};
}

}  // namespace panoptic
