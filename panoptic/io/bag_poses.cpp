// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/bag_poses.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "panoptic/base/files.h"
#include "panoptic/error.h"
#include "panoptic/source.h"

namespace panoptic {
namespace {

constexpr double kNano = 1e-9;

// The first frames of a tree, for messages.
std::string some_of(const std::vector<std::string>& frames) {
  constexpr std::size_t kMost = 12;
  const std::vector<std::string> some(frames.begin(),
                                      frames.begin() + static_cast<std::ptrdiff_t>(std::min(kMost, frames.size())));
  return fmt::format("{}{}", fmt::join(some, ", "), frames.size() > kMost ? " ..." : "");
}

class PoseFinder {
 public:
  PoseFinder(const Bag& bag, const std::vector<RoledTopic>& roles, const BagRoles& chosen, TransformTree tree)
      : bag_(bag), roles_(roles), depth_frame_(roles[chosen.depth].frame), depth_topic_(bag.topics()[chosen.depth].name) {
    result_.tree = std::move(tree);
  }

  BagPoses find(const std::optional<std::uint32_t>& asked) {
    const bool is_asked_for_tf = asked && roles_[*asked].role == BagRole::kTransforms;
    if (asked && !is_asked_for_tf) {
      take_topic(*asked);
    } else if (is_asked_for_tf || transforms_move_camera()) {
      take_transforms();
    } else {
      take_topic(only_topic());
    }
    return std::move(result_);
  }

 private:
  bool transforms_move_camera() const {
    return result_.tree.has(depth_frame_) && result_.tree.moves(result_.tree.chain(depth_frame_, bag_.name()));
  }

  void take_transforms() {
    result_.chain = result_.tree.chain(depth_frame_, bag_.name());
    if (!result_.tree.moves(result_.chain)) refuse_transforms();
    result_.source = fmt::format("TF, {}", fmt::join(result_.chain, " in "));
    const std::string others = names_of(bag_, roles_, {BagRole::kPose});
    if (!others.empty())
      result_.assumed.push_back(
          fmt::format("poses are those of {}; --topics pose=TOPIC takes others: {}", result_.source, others));
  }

  [[noreturn]] void refuse_transforms() const {
    if (!result_.tree.has(depth_frame_)) {
      throw Error(
          fmt::format("{}: no transform leads to the frame '{}' of the depth images {}; the frames are {}; record /tf and "
                      "/tf_static, or choose other poses with --topics pose=TOPIC",
                      bag_.name(), depth_frame_, depth_topic_, some_of(result_.tree.frames())));
    }
    throw Error(
        fmt::format("{}: no transform between the frame '{}' of the depth images and '{}', the root above it, ever changes: "
                    "the moving frames are not connected to it; record /tf and /tf_static",
                    bag_.name(), depth_frame_, result_.tree.chain(depth_frame_, bag_.name()).back()));
  }

  std::uint32_t only_topic() const {
    std::vector<std::uint32_t> topics;
    for (const RoledTopic& r : roles_) {
      if (r.role == BagRole::kPose) topics.push_back(r.topic);
    }
    if (topics.size() == 1) return topics.front();
    if (topics.size() > 1) {
      throw Error(fmt::format("{}: the bag has {} topics of poses; choose with --topics pose=TOPIC: {}", bag_.name(),
                              topics.size(), names_of(bag_, roles_, {BagRole::kPose})));
    }
    if (result_.tree.moves()) refuse_transforms();
    throw NoPoses(
        fmt::format("{}: the bag holds no poses (no Odometry, no PoseStamped, and no TF that changes); record them with the "
                    "images, or let panoptic run --track find them",
                    bag_.name()));
  }

  void take_topic(std::uint32_t index) {
    const BagTopic& topic = bag_.topics()[index];
    std::string child;
    std::size_t damaged = 0;
    for (const BagMessage& message : bag_.messages()) {
      if (message.topic != index) continue;
      try {
        const PoseMessage pose = decode_pose(bag_.read(message), topic.serialization, topic.type);
        if (result_.poses.empty()) child = pose.child;
        result_.poses.push_back({static_cast<double>(pose.header.time_ns) * kNano, pose.position, pose.rotation});
      } catch (const FileError&) {
        throw;
      } catch (const Error&) {
        ++damaged;
      }
    }
    if (damaged > 0) result_.assumed.push_back(fmt::format("{} messages of {} cannot be read", damaged, topic.name));
    std::stable_sort(result_.poses.begin(), result_.poses.end(),
                     [](const auto& a, const auto& b) { return a.time_s < b.time_s; });
    result_.source = topic.name;
    connect(child, topic);
  }

  // From the frame whose pose the topic gives to the depth camera.
  void connect(const std::string& child, const BagTopic& topic) {
    if (child.empty()) {
      result_.assumed.push_back(fmt::format(
          "the poses of {} are those of the depth camera (x right, y down, z forward), since they name no frame", topic.name));
      return;
    }
    if (child == depth_frame_) return;
    const auto fixed = result_.tree.fixed(child, depth_frame_);
    if (!fixed) {
      throw Error(fmt::format(
          "{}: {} gives poses of the frame '{}', and no fixed transform connects it with the frame '{}' of the depth "
          "images; the frames of the transforms: {}; record /tf_static",
          bag_.name(), topic.name, child, depth_frame_, result_.tree.empty() ? "none" : some_of(result_.tree.frames())));
    }
    result_.posed_from_depth = *fixed;
  }

  const Bag& bag_;
  const std::vector<RoledTopic>& roles_;
  std::string depth_frame_;
  std::string depth_topic_;
  BagPoses result_;
};

}  // namespace

TransformTree transforms_of(const Bag& bag, const std::vector<RoledTopic>& roles, std::size_t& damaged) {
  TransformTree tree;
  for (const BagMessage& message : bag.messages()) {
    if (roles[message.topic].role != BagRole::kTransforms) continue;
    const BagTopic& topic = bag.topics()[message.topic];
    try {
      for (const PoseMessage& transform : decode_transforms(bag.read(message), topic.serialization)) {
        tree.add(transform, topic.name.ends_with("tf_static"));
      }
    } catch (const FileError&) {
      throw;
    } catch (const Error&) {
      ++damaged;
    }
  }
  tree.finish();
  return tree;
}

std::optional<Eigen::Matrix4d> BagPoses::at(double time_s) const {
  if (!chain.empty()) return tree.pose(chain, time_s);
  const auto pose = pose_at(poses, time_s, kMaxPoseGap_s);
  if (!pose) return std::nullopt;
  return posed_from_depth.isIdentity(0) ? *pose : Eigen::Matrix4d(*pose * posed_from_depth);
}

BagPoses poses_of(const Bag& bag, const std::vector<RoledTopic>& roles, const BagRoles& chosen, TransformTree tree) {
  return PoseFinder(bag, roles, chosen, std::move(tree)).find(chosen.pose);
}

}  // namespace panoptic
