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
constexpr std::uint64_t kMostMisses = 7;  // for one frame in which a network saw it

Vec3d middle(const Vec3d& min_m, const Vec3d& max_m) { return (min_m + max_m) / 2; }

// Around the same middle. Nothing tells what is the thing and what stands right beside it where no network saw it.
TrackedBox no_larger_than(const TrackedBox& last, TrackedBox box) {
  const Vec3d center = middle(box.min_m, box.max_m);
  const Vec3d half = (box.max_m - box.min_m).cwiseMin(last.max_m - last.min_m) / 2;
  box.min_m = center - half;
  box.max_m = center + half;
  return box;
}

// Networks saw it in one frame of eight, of those that they looked at, or more often.
bool is_mostly_real(const std::map<ClassId, std::uint64_t>& named) {
  std::uint64_t seen = 0;
  std::uint64_t missed = 0;
  for (const auto& [class_id, frames] : named) (class_id == ClassId::kUnknown ? missed : seen) += frames;
  return missed < kMostMisses * seen;
}

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

void MovingTracks::put(const MovingThing& thing, std::int64_t frame, double time_s, bool looked, MovingState::Followed& into) {
  std::vector<TrackedBox>& boxes = into.track.boxes;
  if (boxes.empty() || boxes.back().frame != frame) {
    const bool is_guess = thing.class_id == ClassId::kUnknown && into.track.class_id != ClassId::kUnknown;
    const TrackedBox box{frame, time_s, thing.min_m, thing.max_m};
    boxes.push_back(is_guess ? no_larger_than(boxes.back(), box) : box);
  }
  if (thing.class_id != ClassId::kUnknown || looked) ++into.named[thing.class_id];
  std::uint64_t most = 0;
  for (const auto& [class_id, frames] : into.named) {
    if (class_id == ClassId::kUnknown || frames <= most) continue;
    into.track.class_id = class_id;
    most = frames;
  }
}

void MovingTracks::add(std::span<const MovingThing> things, std::int64_t frame, double time_s, bool looked) {
  std::vector<bool> placed(things.size(), false);
  std::vector<bool> taken(state_.followed.size(), false);
  for (const Match& match : matches(things, time_s)) {
    if (placed[match.thing] || taken[match.track]) continue;
    placed[match.thing] = taken[match.track] = true;
    put(things[match.thing], frame, time_s, looked, state_.followed[match.track]);
  }
  for (std::size_t n = 0; n < things.size(); ++n) {
    if (placed[n]) continue;
    state_.followed.emplace_back().track.id = state_.next_id++;
    put(things[n], frame, time_s, looked, state_.followed.back());
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

std::vector<MovingThing> MovingTracks::expected(double time_s, bool looked) const {
  std::vector<MovingThing> things;
  for (const MovingState::Followed& f : state_.followed) {
    const TrackedBox& last = f.track.boxes.back();
    const double gap_s = time_s - last.time_s;
    if (f.track.class_id == ClassId::kUnknown || gap_s < 0 || gap_s > kLongestGap_s) continue;
    if (looked && !is_mostly_real(f.named)) continue;
    const Vec3d reach = Vec3d::Constant(looked ? 0 : kFastest_m_s * gap_s);
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
