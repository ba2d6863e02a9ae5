// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/camera_tracker.h"

#include <algorithm>
#include <utility>

#include "panoptic/error.h"
#include "panoptic/tracking/keyframes.h"

namespace panoptic {
namespace {

constexpr std::size_t kLeastReadings = 400;   // of about 19,000 that are compared
constexpr double kLeastSurfaceShare = 0.1;    // of these near surface of the map
constexpr double kLeastAgreeingShare = 0.45;  // of those on it
constexpr double kSureAgreeingShare = 0.8;    // below, and less by kLess than before: the camera may have been carried off
constexpr double kLess = 0.1;                 // also by how much a place must fit better to be believed in its stead
constexpr std::size_t kFewGreyPoints = 100;
constexpr double kLeastCorrelation = 0.4;
// A new keyframe every so far, so that its neighbours still show most of what it shows.
constexpr double kKeyframeDistance_m = 0.25;
constexpr double kKeyframeAngle_rad = 0.26;
constexpr double kKeyframeCompared = 0.5;
constexpr std::size_t kRecent = 8;          // keyframes that follow one another directly: no loops
constexpr double kLoopTolerance_m = 0.015;  // the poses fit a loop this well: nothing to correct
constexpr double kLoopTolerance_rad = 0.012;
constexpr double kLoopNoise_m = 0.02;  // two looks from different sides are compared less well than neighbours
constexpr double kLoopNoise_rad = 0.01;
constexpr double kDriftShare = 0.1;  // of the way since: no tracker drifts more
constexpr double kDrift_m = 0.2;
constexpr double kDriftTurn_radpm = 0.02;  // a turn of one degree a metre, and ten degrees
constexpr double kDrift_rad = 0.17;
constexpr std::size_t kTriedAgain = 10;  // frames for which a lost camera is looked for where it was

// The camera level at the origin, looking along y, z up.
Pose level_start() {
  Pose pose = Pose::Identity();
  pose.linear() << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  return pose;
}

bool is_far_enough(const Pose& keyframe, const Pose& pose) {
  const PoseDifference d = difference(keyframe, pose);
  return d.distance_m > kKeyframeDistance_m || d.angle_rad > kKeyframeAngle_rad;
}

Pose between(const Pose& a, const Pose& b, double share) { return a * scaled(a.inverse() * b, share); }

// Whether a pose is good enough to fuse by; else the reason why not.
std::string trouble(const Alignment& a) {
  if (a.readings < kLeastReadings) return "too few depth readings";
  if (a.surface_share < kLeastSurfaceShare) return "hardly anything that the map shows is in view";
  if (a.agreeing_share < kLeastAgreeingShare) return "the depth image does not fit the map";
  if (a.grey_points >= kFewGreyPoints && a.grey_correlation < kLeastCorrelation)
    return "the colour image does not fit the last keyframe";
  return "";
}

struct TrackedFrame {
  std::int64_t frame = 0;
  double time_s = 0;
  std::size_t keyframe = 0;  // the last one up to then
  Pose world_from_camera = Pose::Identity();
  bool is_found = false;  // there, and not by following the one before: between the two the camera may have been carried off
};

}  // namespace

std::string_view to_text(TrackingState state) {
  switch (state) {
    case TrackingState::kBegun:
      return "begun";
    case TrackingState::kTracked:
      return "tracked";
    case TrackingState::kFoundAgain:
      return "found again";
    case TrackingState::kLost:
      break;
  }
  return "lost";
}

class CameraTracker::Parts {
 public:
  explicit Parts(const CameraTrackerOptions& options)
      : range_{options.min_depth_m, options.max_depth_m}, start_(options.start.value_or(level_start())) {
    if (!(range_.min_m > 0 && range_.max_m > range_.min_m)) throw Error("tracking needs depths with 0 < min < max");
    if (!is_finite(start_) || !is_rigid(start_)) throw Error("tracking begins at a pose that is no rigid motion");
  }

  void remember(const Frame& frame);
  CameraPose track(const Frame& frame, const VoxelMap& map);
  void keep(const Frame& frame);
  std::optional<std::vector<FramePose>> corrected_poses();
  std::vector<FramePose> trajectory() const;
  const std::vector<Loop>& loops() const { return loops_; }
  std::size_t keyframes() const { return keyframes_.size(); }

 private:
  Pose predicted(double time_s) const;
  CameraPose begin(const Frame& frame) const;
  CameraPose follow(const Frame& frame, const VoxelMap& map);
  CameraPose find_again(const Frame& frame, const VoxelMap& map);
  bool is_doubtful() const;
  void look_elsewhere(const Frame& frame, const VoxelMap& map);
  bool is_keyframe_due(const CameraPose& pose) const;
  Keyframe keyframe_of(const Frame& frame, const Pose& pose) const;
  void add_keyframe(const Frame& frame);
  void look_for_loops(const Sighting& sighting, std::size_t keyframe);
  double way_m(std::size_t a, std::size_t b) const;
  void correct();

  DepthLimits range_;
  Pose start_;
  std::vector<TrackedFrame> frames_;
  std::vector<Keyframe> keyframes_;
  std::size_t remembered_ = 0;  // the first of them, whose poses stay
  std::size_t reference_ = 0;   // the keyframe that frames are compared with
  double compared_share_ = 1;
  double surface_share_ = 0;        // Alignment::surface_share of the last pose
  double usual_quality_ = 0;        // of the last frame that was not doubtful
  std::size_t lost_ = 0;            // frames since the last one that was known
  std::vector<GreyLevel> pyramid_;  // of the frame that was tracked last,
  CameraPose pose_;                 // and its pose
  std::vector<PoseEdge> edges_;
  std::vector<Loop> loops_;
  bool is_corrected_ = false;
};

void CameraTracker::Parts::remember(const Frame& frame) {
  PANOPTIC_ASSERT(frames_.empty() && keyframes_.size() == remembered_);
  pyramid_ = grey_pyramid(frame.color, frame.color_camera);
  keyframes_.push_back(keyframe_of(frame, frame.world_from_camera));
  ++remembered_;
}

CameraPose CameraTracker::Parts::track(const Frame& frame, const VoxelMap& map) {
  pose_ = {};
  Frame unposed = frame;
  unposed.world_from_camera = Pose::Identity();
  if (const Outcome outcome = check(unposed); !outcome.used) {
    pose_.reason = outcome.reason;
    return pose_;
  }
  pyramid_ = grey_pyramid(frame.color, frame.color_camera);
  if (keyframes_.empty()) {
    pose_ = begin(frame);
  } else {
    if (!frames_.empty() && lost_ < kTriedAgain) pose_ = follow(frame, map);
    if (!pose_.is_known()) {
      CameraPose again = find_again(frame, map);
      if (again.is_known() || pose_.reason.empty()) pose_ = std::move(again);
    } else if (is_doubtful()) {
      look_elsewhere(frame, map);
    }
  }
  if (pose_.is_known() && !is_doubtful()) usual_quality_ = pose_.quality;
  lost_ = pose_.is_known() ? 0 : lost_ + 1;
  return pose_;
}

CameraPose CameraTracker::Parts::begin(const Frame& frame) const {
  CameraPose pose;
  if (depth_points(frame, range_, stride_for(frame, kReadingsAcross)).size() < kLeastReadings) {
    pose.reason = "too few depth readings to begin with";
    return pose;
  }
  pose.state = TrackingState::kBegun;
  pose.world_from_camera = start_;
  pose.quality = 1;
  return pose;
}

// The pose of a camera that goes on moving as between the last two frames; of one that was just found, how it moves is not known.
Pose CameraTracker::Parts::predicted(double time_s) const {
  const TrackedFrame& last = frames_.back();
  if (frames_.size() < 2 || last.is_found) return last.world_from_camera;
  const TrackedFrame& before = frames_[frames_.size() - 2];
  const double step_s = last.time_s - before.time_s;
  constexpr double kMostSteps = 3;
  const double steps = step_s > 0 && time_s > last.time_s ? std::min((time_s - last.time_s) / step_s, kMostSteps) : 1;
  return last.world_from_camera * scaled(before.world_from_camera.inverse() * last.world_from_camera, steps);
}

CameraPose CameraTracker::Parts::follow(const Frame& frame, const VoxelMap& map) {
  const AlignmentTask task{frame, pyramid_, map, &keyframes_[reference_].grey, range_};
  CameraPose pose;
  for (const Pose& start : {predicted(frame.time_s), frames_.back().world_from_camera}) {
    const Alignment alignment = align(task, start);
    pose.reason = trouble(alignment);
    if (!pose.reason.empty()) continue;
    compared_share_ = alignment.grey_share;
    surface_share_ = alignment.surface_share;
    return {TrackingState::kTracked, alignment.world_from_camera, "", alignment.agreeing_share, alignment.covariance};
  }
  return pose;
}

CameraPose CameraTracker::Parts::find_again(const Frame& frame, const VoxelMap& map) {
  const std::vector<Feature> features = find_features(frame, pyramid_, range_);
  constexpr std::size_t kTries = 3;
  CameraPose pose;
  pose.reason = "the place is not recognised";
  for (const Recognition& found : recognise_among({frame, pyramid_, features, range_}, keyframes_, keyframes_.size(), kTries)) {
    const GreyReference& grey = keyframes_[found.keyframe].grey;
    const Alignment alignment = align({frame, pyramid_, map, &grey, range_}, grey.world_from_camera * found.keyframe_from_frame);
    if (std::string reason = trouble(alignment); !reason.empty()) {
      pose.reason = std::move(reason);
      continue;
    }
    reference_ = found.keyframe;
    compared_share_ = 1;
    surface_share_ = alignment.surface_share;
    return {TrackingState::kFoundAgain, alignment.world_from_camera, "", alignment.agreeing_share, alignment.covariance};
  }
  return pose;
}

// The camera was followed to a place that fits all at once much worse than the ones before. Where the map has drifted frames fit
// worse little by little: that is for loops.
bool CameraTracker::Parts::is_doubtful() const {
  return pose_.state == TrackingState::kTracked && pose_.quality < std::min(kSureAgreeingShare, usual_quality_ - kLess);
}

// Looks for a frame that fits the map badly where it may have been carried to. A place at the rim of the map, of which less is in
// view, does not fit better.
void CameraTracker::Parts::look_elsewhere(const Frame& frame, const VoxelMap& map) {
  const std::size_t reference = reference_;
  const double compared = compared_share_;
  const double surface = surface_share_;
  CameraPose elsewhere = find_again(frame, map);
  const PoseDifference off = difference(pose_.world_from_camera, elsewhere.world_from_camera);
  const bool is_elsewhere = off.distance_m > kDrift_m || off.angle_rad > kDrift_rad;
  if (elsewhere.is_known() && is_elsewhere && elsewhere.quality > pose_.quality + kLess && surface_share_ >= surface) {
    pose_ = std::move(elsewhere);
    return;
  }
  reference_ = reference;
  compared_share_ = compared;
  surface_share_ = surface;
}

// The frame joins the others before loops are looked for: they may move it, too.
void CameraTracker::Parts::keep(const Frame& frame) {
  PANOPTIC_ASSERT(pose_.is_known());
  const bool is_due = is_keyframe_due(pose_);
  const std::size_t keyframe = is_due ? keyframes_.size() : keyframes_.size() - 1;
  const bool is_found = pose_.state == TrackingState::kFoundAgain;
  frames_.push_back({frame.index, frame.time_s, keyframe, pose_.world_from_camera, is_found});
  if (is_due) add_keyframe(frame);
}

// One that was found again is always due: it stands beside the keyframe by which it was found, not beside the last one.
bool CameraTracker::Parts::is_keyframe_due(const CameraPose& pose) const {
  if (pose.state != TrackingState::kTracked) return true;
  return compared_share_ < kKeyframeCompared ||
         is_far_enough(keyframes_[reference_].grey.world_from_camera, pose.world_from_camera);
}

Keyframe CameraTracker::Parts::keyframe_of(const Frame& frame, const Pose& pose) const {
  Keyframe keyframe{frame.index, grey_reference(frame, pyramid_, range_), find_features(frame, pyramid_, range_)};
  keyframe.grey.world_from_camera = pose;
  return keyframe;
}

void CameraTracker::Parts::add_keyframe(const Frame& frame) {
  const std::size_t added = keyframes_.size();
  keyframes_.push_back(keyframe_of(frame, pose_.world_from_camera));
  if (added > 0) {
    edges_.push_back({reference_, added, keyframes_[reference_].grey.world_from_camera.inverse() * pose_.world_from_camera});
  }
  reference_ = added;
  compared_share_ = 1;
  look_for_loops({frame, pyramid_, keyframes_[added].features, range_}, added);
}

// How far the camera went from one keyframe to another; the ones that were remembered are where they are.
double CameraTracker::Parts::way_m(std::size_t a, std::size_t b) const {
  double way = 0;
  for (std::size_t k = std::max(a, remembered_); k < b; ++k) {
    way += difference(keyframes_[k].grey.world_from_camera, keyframes_[k + 1].grey.world_from_camera).distance_m;
  }
  return way;
}

void CameraTracker::Parts::look_for_loops(const Sighting& sighting, std::size_t keyframe) {
  if (keyframe <= kRecent) return;
  constexpr std::size_t kMost = 2;
  bool corrects = false;
  const Pose pose = keyframes_[keyframe].grey.world_from_camera;
  for (const Recognition& found : recognise_among(sighting, keyframes_, keyframe - kRecent, kMost)) {
    const Keyframe& earlier = keyframes_[found.keyframe];
    const PoseDifference off = difference(earlier.grey.world_from_camera * found.keyframe_from_frame, pose);
    const double way = way_m(found.keyframe, keyframe);
    if (off.distance_m > kDrift_m + kDriftShare * way || off.angle_rad > kDrift_rad + kDriftTurn_radpm * way) {
      loops_.push_back({sighting.frame.index, earlier.frame, found.keyframe_from_frame, off.distance_m, false, false});
      continue;
    }
    PoseEdge edge{found.keyframe, keyframe, found.keyframe_from_frame};
    edge.distance_noise_m = kLoopNoise_m;
    edge.angle_noise_rad = kLoopNoise_rad;
    edge.may_be_wrong = true;
    edges_.push_back(edge);
    const bool is_off = off.distance_m > kLoopTolerance_m || off.angle_rad > kLoopTolerance_rad;
    loops_.push_back({sighting.frame.index, earlier.frame, found.keyframe_from_frame, off.distance_m, true, is_off});
    corrects = corrects || is_off;
  }
  if (corrects) correct();
}

// The keyframes move to where all edges fit best, and each frame with those before and after it.
void CameraTracker::Parts::correct() {
  std::vector<Pose> before;
  for (const Keyframe& keyframe : keyframes_) before.push_back(keyframe.grey.world_from_camera);
  const std::vector<Pose> after = optimized(before, edges_, std::max<std::size_t>(remembered_, 1));
  for (std::size_t k = 0; k < keyframes_.size(); ++k) keyframes_[k].grey.world_from_camera = after[k];
  const auto corrected = [&](std::size_t k, const Pose& pose) { return after[k] * (before[k].inverse() * pose); };
  std::size_t begin = 0;
  while (begin < frames_.size()) {
    const std::size_t k = frames_[begin].keyframe;
    std::size_t end = begin;
    while (end < frames_.size() && frames_[end].keyframe == k) ++end;
    for (std::size_t i = begin; i < end; ++i) {
      Pose& pose = frames_[i].world_from_camera;
      const std::size_t next = std::min(k + 1, keyframes_.size() - 1);
      const double share = static_cast<double>(i - begin) / static_cast<double>(end - begin);
      pose = between(corrected(k, pose), corrected(next, pose), share);
    }
    begin = end;
  }
  is_corrected_ = true;
}

std::vector<FramePose> CameraTracker::Parts::trajectory() const {
  std::vector<FramePose> poses;
  for (const TrackedFrame& f : frames_) poses.push_back({f.frame, f.time_s, f.world_from_camera});
  return poses;
}

std::optional<std::vector<FramePose>> CameraTracker::Parts::corrected_poses() {
  if (!std::exchange(is_corrected_, false)) return std::nullopt;
  return trajectory();
}

std::vector<std::size_t> keyframes_along(const std::vector<Pose>& path) {
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (places.empty() || is_far_enough(path[places.back()], path[i])) places.push_back(i);
  }
  return places;
}

CameraTracker::CameraTracker(const CameraTrackerOptions& options) : parts_(std::make_unique<Parts>(options)) {}
CameraTracker::~CameraTracker() = default;
CameraTracker::CameraTracker(CameraTracker&&) noexcept = default;
CameraTracker& CameraTracker::operator=(CameraTracker&&) noexcept = default;
void CameraTracker::remember(const Frame& frame) { parts_->remember(frame); }
CameraPose CameraTracker::track(const Frame& frame, const VoxelMap& map) { return parts_->track(frame, map); }
void CameraTracker::keep(const Frame& frame) { parts_->keep(frame); }
std::optional<std::vector<FramePose>> CameraTracker::corrected_poses() { return parts_->corrected_poses(); }
std::vector<FramePose> CameraTracker::trajectory() const { return parts_->trajectory(); }
const std::vector<Loop>& CameraTracker::loops() const { return parts_->loops(); }
std::size_t CameraTracker::keyframes() const { return parts_->keyframes(); }

}  // namespace panoptic
