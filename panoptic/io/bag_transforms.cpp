// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/bag_transforms.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <set>

#include "panoptic/error.h"
#include "panoptic/io/pose_list.h"

namespace panoptic {
namespace {

constexpr double kNano = 1e-9;

bool same_pose(const PoseSample& a, const PoseSample& b) {
  return a.position == b.position && a.rotation.coeffs() == b.rotation.coeffs();
}

}  // namespace

void TransformTree::add(const PoseMessage& transform, bool is_static) {
  Edge& edge = edges_[transform.child];
  const std::string& parent = transform.header.frame;
  if (edge.poses.empty()) edge.parent = parent;
  if (edge.parent != parent) {
    edge.other_parent = parent;
    return;
  }
  const PoseSample pose{static_cast<double>(transform.header.time_ns) * kNano, transform.position, transform.rotation};
  if (is_static) edge.poses.clear();  // the last one holds for all time
  edge.is_static = is_static;
  edge.poses.push_back(pose);
}

void TransformTree::finish() {
  for (auto& [child, edge] : edges_) {
    std::stable_sort(edge.poses.begin(), edge.poses.end(), [](const auto& a, const auto& b) { return a.time_s < b.time_s; });
    const PoseSample first = edge.poses.front();
    const bool is_constant =
        std::all_of(edge.poses.begin(), edge.poses.end(), [&](const auto& p) { return same_pose(p, first); });
    if (!is_constant) continue;
    edge.is_static = true;
    edge.poses.resize(1);
  }
}

bool TransformTree::has(const std::string& frame) const {
  return edges_.contains(frame) ||
         std::any_of(edges_.begin(), edges_.end(), [&](const auto& edge) { return edge.second.parent == frame; });
}

std::vector<std::string> TransformTree::chain(const std::string& frame, const std::string& source) const {
  std::vector<std::string> chain = {frame};
  for (auto edge = edges_.find(frame); edge != edges_.end(); edge = edges_.find(chain.back())) {
    if (!edge->second.other_parent.empty()) {
      throw Error(
          fmt::format("{}: the transforms give the frame {} two parents, {} and {}; choose other poses with --topics pose=TOPIC",
                      source, edge->first, edge->second.parent, edge->second.other_parent));
    }
    if (chain.size() > edges_.size())
      throw Error(fmt::format("{}: the transforms above the frame {} make a circle", source, frame));
    chain.push_back(edge->second.parent);
  }
  return chain;
}

bool TransformTree::moves() const {
  return std::any_of(edges_.begin(), edges_.end(), [](const auto& edge) { return !edge.second.is_static; });
}

bool TransformTree::moves(const std::vector<std::string>& chain) const {
  // The last frame may move in a world above the chain.
  return std::any_of(chain.begin(), std::prev(chain.end()), [&](const std::string& frame) {
    const auto edge = edges_.find(frame);
    return edge != edges_.end() && !edge->second.is_static;
  });
}

std::optional<Eigen::Matrix4d> TransformTree::pose(const std::vector<std::string>& chain, double time_s) const {
  Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
  for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
    const Edge& edge = edges_.at(chain[i]);
    const auto step = edge.is_static ? std::optional(to_matrix4(edge.poses.front().position, edge.poses.front().rotation))
                                     : pose_at(edge.poses, time_s, kMaxPoseGap_s);
    if (!step) return std::nullopt;
    pose = *step * pose;
  }
  return pose;
}

std::optional<Eigen::Matrix4d> TransformTree::fixed(const std::string& target, const std::string& source) const {
  // The frames that are fixed to one, with their own pose in it turned round: ancestor from frame.
  const auto ancestors = [&](std::string frame) {
    std::vector<std::pair<std::string, Eigen::Matrix4d>> found = {{frame, Eigen::Matrix4d::Identity()}};
    for (auto edge = edges_.find(frame); edge != edges_.end() && edge->second.is_static && found.size() <= edges_.size();
         edge = edges_.find(found.back().first)) {
      const PoseSample& pose = edge->second.poses.front();
      found.emplace_back(edge->second.parent, to_matrix4(pose.position, pose.rotation) * found.back().second);
    }
    return found;
  };
  const auto of_target = ancestors(target);
  for (const auto& [frame, frame_from_source] : ancestors(source)) {
    const auto common =
        std::find_if(of_target.begin(), of_target.end(), [&name = frame](const auto& a) { return a.first == name; });
    if (common == of_target.end()) continue;
    if (common->second.isIdentity(0)) return frame_from_source;
    return rigid(common->second).inverse().matrix() * frame_from_source;
  }
  return std::nullopt;
}

std::vector<std::string> TransformTree::frames() const {
  std::set<std::string> frames;
  for (const auto& [child, edge] : edges_) {
    frames.insert(child);
    frames.insert(edge.parent);
  }
  return {frames.begin(), frames.end()};
}

}  // namespace panoptic
