// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A bag as a recording: images are paired by their stamps, and each pair gets the pose of its depth image's time.
#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <variant>

#include "panoptic/bag.h"
#include "panoptic/bags/bag.h"
#include "panoptic/bags/image_messages.h"
#include "panoptic/base/files.h"
#include "panoptic/error.h"
#include "panoptic/io/bag_cameras.h"
#include "panoptic/io/bag_poses.h"
#include "panoptic/io/bag_roles.h"
#include "panoptic/io/calibration.h"
#include "panoptic/io/dataset_formats.h"
#include "panoptic/io/dataset_frame.h"
#include "panoptic/io/time_pairing.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

constexpr double kNano = 1e-9;

struct StampedMessage {
  std::int64_t time_ns = 0;
  BagMessage message;
};

// One position of the sequence.
struct BagFrame {
  double time_s = 0;
  std::optional<BagMessage> depth;
  std::optional<BagMessage> color;
  std::optional<Eigen::Matrix4d> pose;
  std::string problem;
};

// Orders the messages of a topic by the stamps in their headers or, where those were never set, by when they were recorded.
void settle_order(std::vector<StampedMessage>& list, const std::string& topic, RecordingNotes& notes) {
  if (!list.empty() && std::all_of(list.begin(), list.end(), [](const StampedMessage& m) { return m.time_ns == 0; })) {
    notes.assumed.push_back(fmt::format("the images of {} have no stamps: they are of the time when they were recorded", topic));
    for (StampedMessage& m : list) m.time_ns = m.message.time_ns;
  }
  std::stable_sort(list.begin(), list.end(), [](const auto& a, const auto& b) { return a.time_ns < b.time_ns; });
}

// The messages of some topics, in one walk over the bag: its chunks are unpacked one after the other.
std::vector<std::vector<StampedMessage>> stamped(const Bag& bag, const std::vector<std::uint32_t>& topics,
                                                 RecordingNotes& notes) {
  constexpr std::uint64_t kHeaderBytes = 512;
  std::vector<std::vector<StampedMessage>> lists(topics.size());
  std::vector<std::size_t> damaged(topics.size());
  for (const BagMessage& message : bag.messages()) {
    const auto at = static_cast<std::size_t>(std::find(topics.begin(), topics.end(), message.topic) - topics.begin());
    if (at == topics.size()) continue;
    try {
      const BagTopic& topic = bag.topics()[message.topic];
      lists[at].push_back({decode_header(bag.read(message, kHeaderBytes), topic.serialization).time_ns, message});
    } catch (const FileError&) {
      throw;
    } catch (const Error&) {
      ++damaged[at];
    }
  }
  for (std::size_t i = 0; i < topics.size(); ++i) {
    const std::string& name = bag.topics()[topics[i]].name;
    if (damaged[i] > 0) notes.left_out.push_back(fmt::format("{} messages of {}, which cannot be read", damaged[i], name));
    settle_order(lists[i], name, notes);
  }
  return lists;
}

std::vector<double> times_of(const std::vector<StampedMessage>& list) {
  std::vector<double> times_s;
  times_s.reserve(list.size());
  for (const StampedMessage& m : list) times_s.push_back(static_cast<double>(m.time_ns) * kNano);
  return times_s;
}

struct ImageTimes {
  std::vector<StampedMessage> color;
  std::vector<StampedMessage> depth;
  double tolerance_s = kMaxTimeDifference_s;
};

// Without poses every frame has the identity.
std::vector<BagFrame> frames_of(const ImageTimes& images, const std::optional<BagPoses>& poses) {
  const std::vector<double> color_s = times_of(images.color);
  const std::vector<double> depth_s = times_of(images.depth);
  std::vector<BagFrame> frames;
  for (const TimePair& pair : paired_by_time(color_s, depth_s, images.tolerance_s)) {
    BagFrame frame;
    frame.time_s = pair.depth ? depth_s[*pair.depth] : color_s[*pair.color];
    if (pair.color) frame.color = images.color[*pair.color].message;
    if (pair.depth) frame.depth = images.depth[*pair.depth].message;
    frame.pose = poses ? poses->at(frame.time_s) : Eigen::Matrix4d(Eigen::Matrix4d::Identity());
    if (!pair.depth) frame.problem = fmt::format("no depth image within {} s", images.tolerance_s);
    if (!pair.color) frame.problem = fmt::format("no colour image within {} s", images.tolerance_s);
    if (frame.problem.empty() && !frame.pose)
      frame.problem =
          fmt::format("no pose: none within {} s, nor two less than {} s apart around it", kMaxTimeDifference_s, kMaxPoseGap_s);
    frames.push_back(std::move(frame));
  }
  std::stable_sort(frames.begin(), frames.end(), [](const BagFrame& a, const BagFrame& b) { return a.time_s < b.time_s; });
  return frames;
}

// Clocks of another beginning leave every image without a partner, or without a pose.
void require_one_clock(const Bag& bag, const std::vector<BagFrame>& frames, const std::string& pose_source, double tolerance_s) {
  const auto any = [&](auto test) { return std::any_of(frames.begin(), frames.end(), test); };
  if (!any([](const BagFrame& f) { return f.color && f.depth; })) {
    throw Error(
        fmt::format("{}: no colour image lies within {} s of a depth image; are the stamps of one clock? --pair-tolerance S "
                    "allows more",
                    bag.name(), tolerance_s));
  }
  if (!any([](const BagFrame& f) { return f.pose.has_value(); })) {
    throw Error(fmt::format(
        "{}: no image has a pose in {}: none lies within {} s of one, nor between two that are less than {} s apart; are "
        "the stamps of one clock?",
        bag.name(), pose_source, kMaxTimeDifference_s, kMaxPoseGap_s));
  }
}

DepthImage depth_in(const Bag& bag, const BagMessage& message) {
  const BagTopic& topic = bag.topics()[message.topic];
  const BagBytes bytes = bag.read(message);
  return topic.type == kImageType ? depth_of(decode_image(bytes, topic.serialization))
                                  : depth_of(decode_compressed_image(bytes, topic.serialization));
}

Image<Rgb> color_in(const Bag& bag, const BagMessage& message) {
  const BagTopic& topic = bag.topics()[message.topic];
  const BagBytes bytes = bag.read(message);
  return topic.type == kImageType ? color_of(decode_image(bytes, topic.serialization))
                                  : color_of(decode_compressed_image(bytes, topic.serialization));
}

ImageSize size_of(const Image<Rgb>& image) { return {image.width(), image.height()}; }
ImageSize size_of(const DepthImage& depth) {
  return std::visit([](const auto& image) { return ImageSize{image.width(), image.height()}; }, depth);
}

// The size of the first image that can be read.
template <typename Read>
ImageSize first_size(const Bag& bag, const std::vector<StampedMessage>& list, const char* what, const Read& read) {
  std::string reason = "there is none";
  for (const StampedMessage& m : list) {
    try {
      return size_of(read(bag, m.message));
    } catch (const FileError&) {
      throw;
    } catch (const Error& e) {
      if (&m == &list.front()) reason = e.what();
    }
  }
  throw Error(fmt::format("{}: no {} image can be read (the first: {})", bag.name(), what, reason));
}

class BagDataset : public Dataset {
 public:
  BagDataset(const fs::path& path, const BagChoice& choice, const fs::path& calibration, const PairingOptions& pairing)
      : bag_(path) {
    const std::vector<RoledTopic> roles = roles_of(bag_);
    const BagRoles chosen = choose(bag_, roles, choice);
    notes_.assumed = chosen.assumed;
    notes_.left_out = bag_.left_out();
    std::size_t damaged = 0;
    TransformTree tree = transforms_of(bag_, roles, damaged);
    if (damaged > 0) notes_.left_out.push_back(fmt::format("{} messages of transforms, which cannot be read", damaged));
    calibration_ = calibration_of(bag_, roles, chosen, tree, !calibration.empty(), notes_.assumed);
    if (!calibration.empty()) read_calibration(calibration, calibration_);
    const std::optional<BagPoses> poses =
        pairing.without_poses ? std::nullopt : std::optional(poses_of(bag_, roles, chosen, std::move(tree)));
    if (poses) notes_.assumed.insert(notes_.assumed.end(), poses->assumed.begin(), poses->assumed.end());
    auto lists = stamped(bag_, {chosen.color, chosen.depth}, notes_);
    const ImageTimes images{std::move(lists[0]), std::move(lists[1]), pairing.tolerance_s.value_or(kMaxTimeDifference_s)};
    frames_ = frames_of(images, poses);
    require_one_clock(bag_, frames_, poses ? poses->source : "", images.tolerance_s);
    calibration_ = fitted(calibration_, first_size(bag_, images.depth, "depth", depth_in),
                          first_size(bag_, images.color, "colour", color_in), bag_.name());
    if (calibration_.color_is_assumed) {
      notes_.assumed.emplace_back(
          "colour images show what depth images show, pixel for pixel: they are of one frame, and colour has no "
          "CameraInfo; --calibration FILE.toml gives others");
    }
    notes_.depth_scale = calibration_.depth_scale;
  }

  std::string description() const override {
    const Camera& depth = calibration_.depth;
    const Camera& color = *calibration_.color;
    return fmt::format("{}, {} frames, depth {}x{}, colour {}x{}", bag_.container(), size(), depth.width, depth.height,
                       color.width, color.height);
  }

  std::size_t size() const override { return frames_.size(); }

  ReadResult read(std::size_t position) const override {
    PANOPTIC_ASSERT(position < size());
    const BagFrame& frame = frames_[position];
    const auto number = static_cast<std::int64_t>(position);
    if (!frame.problem.empty()) return skipped(number, frame.problem);
    RawFrame raw{number, frame.time_s, *frame.pose, {}, {}};
    // Before the costly decoding.
    if (const Outcome outcome = check_pose(raw.pose); !outcome.used) return skipped(number, outcome.reason);
    const char* what = "depth";
    try {
      DepthImage depth = depth_in(bag_, *frame.depth);
      raw.depth = std::visit([&](auto& image) { return to_metres(std::move(image), calibration_); }, depth);
      what = "colour";
      raw.color = color_in(bag_, *frame.color);
    } catch (const Error& e) {
      return skipped(number, fmt::format("{} image unreadable: {}", what, e.what()));
    }
    return finish(std::move(raw), calibration_);
  }

  std::optional<Pose> pose(std::size_t position) const override {
    PANOPTIC_ASSERT(position < size());
    const BagFrame& frame = frames_[position];
    if (!frame.problem.empty() || !check_pose(*frame.pose).used) return std::nullopt;
    return camera_pose(*frame.pose, calibration_);
  }

  RecordingNotes notes() const override { return notes_; }

 private:
  Bag bag_;
  Calibration calibration_;  // fitted
  std::vector<BagFrame> frames_;
  RecordingNotes notes_;
};

}  // namespace

BagChoice parse_bag_choice(const std::string& text) {
  BagChoice choice;
  std::string_view left = text;
  while (!left.empty()) {
    const std::string_view part = left.substr(0, left.find(','));
    left.remove_prefix(std::min(left.size(), part.size() + 1));
    const std::size_t equals = part.find('=');
    const std::string_view key = part.substr(0, equals);
    std::string* topic = key == "depth"   ? &choice.depth
                         : key == "color" ? &choice.color
                         : key == "info"  ? &choice.info
                         : key == "pose"  ? &choice.pose
                                          : nullptr;
    if (topic == nullptr || equals == std::string_view::npos || equals + 1 == part.size() || !topic->empty()) {
      throw Error(fmt::format(
          "'{}' is no choice of topics; expected depth=TOPIC,color=TOPIC,info=TOPIC,pose=TOPIC, each at most once", text));
    }
    *topic = std::string(part.substr(equals + 1));
  }
  return choice;
}

bool is_bag_recording(const fs::path& path) { return is_bag(path); }

BagListing list_bag(const fs::path& path) {
  const Bag bag(path);
  BagListing listing{bag.container(), 0, 0, {}, bag.left_out()};
  if (!bag.messages().empty()) {
    listing.begin_s = static_cast<double>(bag.messages().front().time_ns) * kNano;
    listing.end_s = static_cast<double>(bag.messages().back().time_ns) * kNano;
  }
  for (const RoledTopic& r : roles_of(bag)) {
    const BagTopic& topic = bag.topics()[r.topic];
    std::string note = r.note;
    if (!r.frame.empty()) note += fmt::format("{}frame {}", note.empty() ? "" : ", ", r.frame);
    listing.topics.push_back({topic.name, topic.type, topic.messages, std::string(role_name(r.role)), note});
  }
  std::sort(listing.topics.begin(), listing.topics.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return listing;
}

fs::path path_of_recording(const std::string& name) { return is_there(name) ? name : name.substr(0, name.rfind('?')); }

std::unique_ptr<Dataset> open_bag(const fs::path& path, const BagChoice& choice, const fs::path& calibration,
                                  std::optional<double> pair_tolerance_s) {
  return open_bag_as(path, choice, calibration, {.tolerance_s = pair_tolerance_s});
}

std::unique_ptr<Dataset> open_bag_as(const fs::path& path, const BagChoice& choice, const fs::path& calibration,
                                     const PairingOptions& pairing) {
  const fs::path absolute = fs::absolute(path).lexically_normal();
  if (!is_there(absolute)) throw Error(fmt::format("{}: no such file or folder; give the path of a bag", absolute.string()));
  if (!is_bag(absolute))
    throw Error(fmt::format(
        "{}: no bag, so it has no topics to choose from; leave out the choice (--topics, or what follows ? in its name)",
        absolute.string()));
  return std::make_unique<BagDataset>(absolute, choice, calibration, pairing);
}

}  // namespace panoptic
