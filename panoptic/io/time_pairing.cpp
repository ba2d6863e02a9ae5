// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/time_pairing.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "panoptic/io/pose_list.h"

namespace panoptic {
namespace {

constexpr std::size_t kMaxCandidates = 32;  // per depth image: 0.04 s at 800 Hz; bounds the work on a file of equal stamps

struct Candidate {
  double difference_s;
  std::size_t color;
  std::size_t depth;
};

std::vector<Candidate> candidates_of(const std::vector<double>& color_s, const std::vector<double>& depth_s, double tolerance_s) {
  std::vector<Candidate> candidates;
  std::size_t first = 0;
  for (std::size_t d = 0; d < depth_s.size(); ++d) {
    while (first < color_s.size() && color_s[first] < depth_s[d] - tolerance_s) ++first;
    for (std::size_t c = first; c < std::min(color_s.size(), first + kMaxCandidates); ++c) {
      const double difference_s = std::abs(color_s[c] - depth_s[d]);
      if (difference_s <= tolerance_s) candidates.push_back({difference_s, c, d});
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.difference_s < b.difference_s; });
  return candidates;
}

}  // namespace

std::vector<TimePair> paired_by_time(const std::vector<double>& color_s, const std::vector<double>& depth_s, double tolerance_s) {
  std::vector<TimePair> pairs;
  std::vector<bool> color_used(color_s.size());
  std::vector<bool> depth_used(depth_s.size());
  for (const Candidate& candidate : candidates_of(color_s, depth_s, tolerance_s)) {
    if (color_used[candidate.color] || depth_used[candidate.depth]) continue;
    color_used[candidate.color] = true;
    depth_used[candidate.depth] = true;
    pairs.push_back({candidate.color, candidate.depth});
  }
  for (std::size_t c = 0; c < color_s.size(); ++c) {
    if (!color_used[c]) pairs.push_back({c, std::nullopt});
  }
  for (std::size_t d = 0; d < depth_s.size(); ++d) {
    if (!depth_used[d]) pairs.push_back({std::nullopt, d});
  }
  return pairs;
}

std::optional<Eigen::Matrix4d> pose_at(const std::vector<PoseSample>& poses, double time_s, double bracket_s) {
  const auto after =
      std::lower_bound(poses.begin(), poses.end(), time_s, [](const PoseSample& p, double t) { return p.time_s < t; });
  if (after != poses.end() && after->time_s == time_s) return to_matrix4(after->position, after->rotation);
  if (after != poses.end() && after != poses.begin()) {
    const PoseSample& b = *after;
    const PoseSample& a = *std::prev(after);
    if (b.time_s - a.time_s < bracket_s) {
      const double t = (time_s - a.time_s) / (b.time_s - a.time_s);
      return to_matrix4((1 - t) * a.position + t * b.position, a.rotation.slerp(t, b.rotation));
    }
  }
  const auto distance_s = [&](auto p) { return p == poses.end() ? HUGE_VAL : std::abs(p->time_s - time_s); };
  const auto before = after == poses.begin() ? poses.end() : std::prev(after);
  const auto nearest = distance_s(before) < distance_s(after) ? before : after;
  if (distance_s(nearest) > kMaxTimeDifference_s) return std::nullopt;
  return to_matrix4(nearest->position, nearest->rotation);
}

}  // namespace panoptic
