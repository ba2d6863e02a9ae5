// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects/moving_tracks.h"

#include <algorithm>
#include <utility>

namespace panoptic {
namespace {

constexpr double kFastest_m_s = 2;  // a brisk walk
constexpr double kStride_m = 0.5;   // what one sees of a body changes by as much from frame to frame
constexpr double kLongestGap_s = 1;
constexpr std::size_t kFewestFrames = 3;

Vec3d middle(const Vec3d& min_m, const Vec3d& max_m) { return (min_m + max_m) / 2; }

bool may_be(ClassId thing, ClassId track) { return thing == track || thing == ClassId::kUnknown || track == ClassId::kUnknown; }

}  // namespace

// Pairs that may be, the nearest first.
std::vector<MovingTracks::Match> MovingTracks::matches(std::span<const MovingThing> things, double time_s) const {
  std::vector<Match> found;
  for (std::size_t t = 0; t < state_.followed.size(); ++t) {
    const MovingTrack& track = state_.followed[t].track;
    const TrackedBox& last = track.boxes.back();
    const double gap_s = time_s - last.time_s;
    if (gap_s < 0 || gap_s > kLongestGap_s) continue;
    for (std::size_t n = 0; n < things.size(); ++n) {
      if (!may_be(things[n].class_id, track.class_id)) continue;
      const double distance_m = (middle(things[n].min_m, things[n].max_m) - middle(last.min_m, last.max_m)).norm();
      if (distance_m <= kStride_m + kFastest_m_s * gap_s) found.push_back({n, t, distance_m});
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const Match& a, const Match& b) { return a.distance_m < b.distance_m; });
  return found;
}

void MovingTracks::put(const MovingThing& thing, std::int64_t frame, double time_s, MovingState::Followed& into) const {
  std::vector<TrackedBox>& boxes = into.track.boxes;
  if (boxes.empty() || boxes.back().frame != frame) boxes.push_back({frame, time_s, thing.min_m, thing.max_m});
  if (thing.class_id == ClassId::kUnknown) return;
  ++into.named[thing.class_id];
  into.track.class_id = std::max_element(into.named.begin(), into.named.end(), [](const auto& a, const auto& b) {
                          return a.second < b.second;
                        })->first;
}

void MovingTracks::add(std::span<const MovingThing> things, std::int64_t frame, double time_s) {
  std::vector<bool> placed(things.size(), false);
  std::vector<bool> taken(state_.followed.size(), false);
  for (const Match& match : matches(things, time_s)) {
    if (placed[match.thing] || taken[match.track]) continue;
    placed[match.thing] = taken[match.track] = true;
    put(things[match.thing], frame, time_s, state_.followed[match.track]);
  }
  for (std::size_t n = 0; n < things.size(); ++n) {
    if (placed[n]) continue;
    state_.followed.emplace_back().track.id = state_.next_id++;
    put(things[n], frame, time_s, state_.followed.back());
  }
  // A thing that was seen once or twice and never again is noise.
  std::erase_if(state_.followed, [&](const MovingState::Followed& f) {
    return f.track.boxes.size() < kFewestFrames && time_s - f.track.boxes.back().time_s > kLongestGap_s;
  });
  forget_oldest();
}

void MovingTracks::forget_oldest() {
  std::size_t boxes = 0;
  for (const MovingState::Followed& f : state_.followed) boxes += f.track.boxes.size();
  while (boxes > kMostBoxes && state_.followed.size() > 1) {
    boxes -= state_.followed.front().track.boxes.size();
    state_.forgotten += state_.followed.front().track.boxes.size();
    state_.followed.erase(state_.followed.begin());
  }
  if (boxes <= kMostBoxes) return;
  std::vector<TrackedBox>& only = state_.followed.front().track.boxes;
  state_.forgotten += boxes - kMostBoxes;
  only.erase(only.begin(), only.end() - kMostBoxes);
}

std::vector<MovingThing> MovingTracks::expected(double time_s) const {
  std::vector<MovingThing> things;
  for (const MovingState::Followed& f : state_.followed) {
    const TrackedBox& last = f.track.boxes.back();
    const double gap_s = time_s - last.time_s;
    if (f.track.class_id == ClassId::kUnknown || gap_s < 0 || gap_s > kLongestGap_s) continue;
    const Vec3d reach = Vec3d::Constant(kFastest_m_s * gap_s);
    things.push_back({f.track.class_id, last.min_m - reach, last.max_m + reach, 0});
  }
  return things;
}

std::vector<MovingTrack> MovingTracks::tracks() const {
  std::vector<MovingTrack> seen;
  for (const MovingState::Followed& f : state_.followed) {
    if (f.track.boxes.size() >= kFewestFrames) seen.push_back(f.track);
  }
  return seen;
}

}  // namespace panoptic
