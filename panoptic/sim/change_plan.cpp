// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/change_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "panoptic/sim/free_places.h"
#include "panoptic/sim/random.h"
#include "panoptic/sim/renderer.h"
#include "panoptic/sim/view_log.h"

namespace panoptic {
namespace {

constexpr std::uint64_t kPurpose = 0x6368616e;
constexpr std::size_t kStride = 4;       // every fourth frame is looked at
constexpr std::size_t kElsewhere = 15;   // views before and after a change that show nothing of it: two seconds
constexpr std::size_t kShown = 8;        // views that show a place before, and again after: a second
constexpr std::size_t kMostMoments = 5;  // changes share moments: each costs its own picture of the home
constexpr double kAside_m = 0.9;         // the camera is through a door when it is so far away
constexpr ClassId kDoorClass{8};
constexpr std::array<ClassId, 7> kMovable = {ClassId{3},  ClassId{5},  ClassId{6}, ClassId{7},
                                             ClassId{10}, ClassId{14}, ClassId{39}};  // cabinet, chair, sofa, table ...

// A thing or a place, view by view.
struct Appearance {
  std::vector<bool> seen;   // anything of it
  std::vector<bool> shown;  // enough of it
};

class ChangePlan {
 public:
  ChangePlan(std::uint64_t seed, const std::vector<Pose>& path, const Camera& camera, Home& home)
      : home_(home),
        path_(path),
        random_(seed, kPurpose),
        log_(Renderer(home.scene), home.scene.objects.size(), path, camera, kStride),
        places_(home, path),
        boxes_(thing_boxes(home.scene)),
        elsewhere_(std::clamp<std::size_t>(log_.views().size() / 20, 2, kElsewhere)),
        shown_(std::clamp<std::size_t>(log_.views().size() / 40, 2, kShown)) {
    for (std::uint32_t i = 0; i < home.scene.objects.size(); ++i) {
      if (home.scene.objects[i].instance != 0) object_of_[home.scene.objects[i].instance] = i;
    }
  }

  std::vector<Change> make() {
    std::vector<ThingBox> candidates = boxes_;
    random_.shuffle(candidates);
    for (const ThingBox& thing : candidates) {
      if (class_of(thing) == kDoorClass && try_door(thing)) break;
    }
    const std::size_t most = std::clamp<std::size_t>(2 + home_.rooms.size(), 3, 8);
    for (const ThingBox& thing : candidates) {
      if (changes_.size() >= most) break;
      if (is_movable(thing)) try_change(thing);
    }
    std::stable_sort(changes_.begin(), changes_.end(), [](const Change& a, const Change& b) { return a.frame < b.frame; });
    return std::move(changes_);
  }

 private:
  ClassId class_of(const ThingBox& thing) const { return home_.scene.objects[object_of_.at(thing.instance)].class_id; }

  bool carries_something(const ThingBox& thing) const {
    return std::any_of(boxes_.begin(), boxes_.end(), [&](const ThingBox& other) {
      const bool is_on_top = other.bottom_m > 0.1 && std::abs(other.bottom_m - thing.top_m) < 0.06;
      return other.instance != thing.instance && (is_on_top || other.bottom_m > 0.1) && other.bottom_m < thing.top_m + 0.06 &&
             other.top_m > thing.bottom_m && overlap(other.base, thing.base);
    });
  }

  bool is_movable(const ThingBox& thing) const {
    constexpr double kSmallest_m = 0.35;
    constexpr double kLargest_m = 2.3;
    constexpr double kHighest_m = 1.5;
    const double width_m = 2 * thing.base.half_m.maxCoeff();
    const double size_m = std::max(width_m, thing.top_m - thing.bottom_m);
    return std::find(kMovable.begin(), kMovable.end(), class_of(thing)) != kMovable.end() && thing.bottom_m < 0.03 &&
           size_m > kSmallest_m && width_m < kLargest_m && thing.top_m < kHighest_m && !carries_something(thing);
  }

  Appearance appearance_of(const ThingBox& thing) const {
    const std::uint32_t object = object_of_.at(thing.instance);
    Appearance it;
    for (const SmallView& view : log_.views()) {
      it.seen.push_back(view.pixels[object] > 0);
      it.shown.push_back(view.near[object] >= log_.enough_px());
    }
    return it;
  }

  Appearance appearance_of_place(const ThingBox& place) const {
    const Eigen::AlignedBox3d box = box_of(place);
    Appearance it;
    for (const SmallView& view : log_.views()) {
      const ViewLog::Points points = log_.points_in(view, box);
      it.seen.push_back(points.seen > 0);
      it.shown.push_back(points.near >= ViewLog::kEnoughPoints);
    }
    return it;
  }

  // Views at which a change could happen unseen, with the place shown before and afterwards.
  std::vector<std::size_t> unseen_moments(const Appearance& it) const {
    const std::size_t count = it.seen.size();
    std::vector<std::size_t> shown(count + 1, 0);
    std::vector<std::size_t> seen(count + 1, 0);
    for (std::size_t i = 0; i < count; ++i) {
      shown[i + 1] = shown[i] + (it.shown[i] ? 1 : 0);
      seen[i + 1] = seen[i] + (it.seen[i] ? 1 : 0);
    }
    std::vector<std::size_t> moments;
    for (std::size_t i = elsewhere_; i + elsewhere_ < count; ++i) {
      const bool is_elsewhere = seen[i + elsewhere_ + 1] == seen[i - elsewhere_];
      if (is_elsewhere && shown[i] >= shown_ && shown[count] - shown[i] >= shown_) moments.push_back(i);
    }
    return moments;
  }

  // One of the moments at which something happens already, or a new one.
  std::optional<std::size_t> choose(const std::vector<std::size_t>& moments) {
    std::vector<std::size_t> shared;
    std::set_intersection(moments.begin(), moments.end(), moments_.begin(), moments_.end(), std::back_inserter(shared));
    if (!shared.empty()) return random_.pick(shared);
    if (moments.empty() || moments_.size() >= kMostMoments) return std::nullopt;
    return random_.pick(moments);
  }

  void add(Change change, std::size_t moment) {
    change.frame = log_.views()[moment].frame;
    changes_.push_back(change);
    if (!std::binary_search(moments_.begin(), moments_.end(), moment)) {
      moments_.insert(std::upper_bound(moments_.begin(), moments_.end(), moment), moment);
    }
  }

  // The thing once more, where `place` is.
  std::uint32_t put(const ThingBox& thing, const ThingBox& place) {
    SceneObject object = home_.scene.objects[object_of_.at(thing.instance)];
    const Eigen::Vector2d& was = thing.base.axis;
    const Eigen::Vector2d& is = place.base.axis;
    const double angle = std::atan2(was.x() * is.y() - was.y() * is.x(), was.dot(is));
    const Pose turned_about_center = Eigen::Translation3d(place.base.center.x(), place.base.center.y(), 0) *
                                     Eigen::AngleAxisd(angle, Vec3d::UnitZ()) *
                                     Eigen::Translation3d(-thing.base.center.x(), -thing.base.center.y(), 0);
    object.world_from_object = turned_about_center * object.world_from_object;
    home_.scene.objects.push_back(std::move(object));
    places_.take(place);
    return static_cast<std::uint32_t>(home_.scene.objects.size() - 1);
  }

  bool try_move(const ThingBox& thing, const std::vector<std::size_t>& moments) {
    constexpr int kPlaces = 4;
    for (int i = 0; i < kPlaces; ++i) {
      const std::optional<ThingBox> place = places_.find(thing, random_);
      if (!place) return false;
      std::vector<std::size_t> both;
      const std::vector<std::size_t> there = unseen_moments(appearance_of_place(*place));
      std::set_intersection(moments.begin(), moments.end(), there.begin(), there.end(), std::back_inserter(both));
      const auto moment = choose(both);
      if (!moment) continue;
      add({EventKind::kMoved, 0, thing.instance, object_of_.at(thing.instance), put(thing, *place)}, *moment);
      return true;
    }
    return false;
  }

  void try_change(const ThingBox& thing) {
    const std::vector<std::size_t> moments = unseen_moments(appearance_of(thing));
    if (moments.empty()) return;
    const double what = random_.uniform();
    if (what < 0.45 && try_move(thing, moments)) return;
    const auto moment = choose(moments);
    if (!moment) return;
    const std::uint32_t object = object_of_.at(thing.instance);
    if (what < 0.75) {
      add({EventKind::kRemoved, 0, thing.instance, object, std::nullopt}, *moment);
    } else {
      add({EventKind::kAdded, 0, thing.instance, std::nullopt, object}, *moment);
    }
  }

  // An open leaf is shut after the camera has gone through its doorway for the last time.
  bool try_door(const ThingBox& leaf) {
    for (const Doorway& doorway : home_.doorways) {
      const double away_m = (doorway.center - leaf.base.center).norm();
      if (away_m > 0.9 * doorway.width_m + 0.1 || away_m < 0.3) continue;
      std::size_t last = 0;
      for (std::size_t frame = 0; frame < path_.size(); ++frame) {
        if ((path_[frame].translation().head<2>() - doorway.center).norm() < kAside_m) last = frame;
      }
      ThingBox shut = leaf;
      shut.base.center = doorway.center;
      shut.base.axis = leaf.base.across();
      std::vector<std::size_t> moments = unseen_moments(appearance_of(leaf));
      std::erase_if(moments, [&](std::size_t i) { return log_.views()[i].frame <= last; });
      const Appearance closed = appearance_of_place(shut);
      std::erase_if(moments, [&](std::size_t i) {
        return std::count(closed.seen.begin() + static_cast<std::ptrdiff_t>(i - elsewhere_),
                          closed.seen.begin() + static_cast<std::ptrdiff_t>(i + elsewhere_), true) > 0;
      });
      const auto moment = choose(moments);
      if (!moment) continue;
      add({EventKind::kDoor, 0, leaf.instance, object_of_.at(leaf.instance), put(leaf, shut)}, *moment);
      return true;
    }
    return false;
  }

  Home& home_;
  const std::vector<Pose>& path_;
  Random random_;
  ViewLog log_;
  FreePlaces places_;
  std::vector<ThingBox> boxes_;
  std::size_t elsewhere_;
  std::size_t shown_;
  std::map<std::uint16_t, std::uint32_t> object_of_;
  std::vector<std::size_t> moments_;  // views, ascending
  std::vector<Change> changes_;
};

}  // namespace

std::vector<Change> plan_changes(std::uint64_t seed, const std::vector<Pose>& path, const Camera& camera, Home& home) {
  return ChangePlan(seed, path, camera, home).make();
}

}  // namespace panoptic
