// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/bag_roles.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "panoptic/bags/image_messages.h"
#include "panoptic/bags/messages.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr std::uint64_t kHeadBytes = 1024;  // names of frames and encodings are shorter

BagRole to_role(ImageKind kind) {
  switch (kind) {
    case ImageKind::kDepth:
      return BagRole::kDepth;
    case ImageKind::kColor:
      return BagRole::kColor;
    case ImageKind::kGrey:
      return BagRole::kGrey;
    case ImageKind::kUnknown:
      break;
  }
  return BagRole::kNone;
}

RoledTopic role_of_image(const BagTopic& topic, const BagBytes& head) {
  RoledTopic roled;
  if (topic.type == kImageType) {
    const ImageMessage image = decode_image_head(head, topic.serialization);
    roled = {0, to_role(kind_of_encoding(image.encoding, topic.name)), image.header.frame, image.encoding};
  } else {
    const CompressedImageMessage image = decode_compressed_image_head(head, topic.serialization);
    roled = {0, to_role(kind_of_format(image.format, topic.name)), image.header.frame, image.format};
  }
  if (roled.role == BagRole::kNone) roled.note = fmt::format("encoding '{}' cannot be read", roled.note);
  return roled;
}

RoledTopic role_of(const BagTopic& topic, const BagBytes& head) {
  if (topic.type == kImageType || topic.type == kCompressedImageType) return role_of_image(topic, head);
  if (is_transforms_type(topic.type)) return {0, BagRole::kTransforms, "", ""};
  if (topic.type == kCameraInfoType) return {0, BagRole::kInfo, decode_header(head, topic.serialization).frame, ""};
  if (is_pose_type(topic.type)) return {0, BagRole::kPose, decode_header(head, topic.serialization).frame, ""};
  return {};
}

// The topic without the name of its transport: "/depth/image/compressedDepth" is "/depth/image".
std::string without_transport(const std::string& name) {
  for (const std::string_view transport : {"/compressed", "/compressedDepth"}) {
    if (name.ends_with(transport)) return name.substr(0, name.size() - transport.size());
  }
  return name;
}

std::string parent_of(const std::string& name) { return name.substr(0, std::min(name.rfind('/'), name.size())); }

// The CameraInfo beside a topic of images.
std::optional<std::uint32_t> info_beside(const Bag& bag, const std::vector<RoledTopic>& roles, const std::string& images) {
  const std::string folder = parent_of(without_transport(images));
  const std::array<std::string, 2> names = {folder + "/camera_info", parent_of(folder) + "/info/camera_info"};
  for (const std::string& name : names) {
    for (const RoledTopic& r : roles) {
      if (r.role == BagRole::kInfo && bag.topics()[r.topic].name == name) return r.topic;
    }
  }
  return std::nullopt;
}

class Chooser {
 public:
  Chooser(const Bag& bag, const std::vector<RoledTopic>& roles) : bag_(bag), roles_(roles) {}

  // The topic of a role by the name that the user gave.
  std::uint32_t named(const std::string& name, const char* key, const std::vector<BagRole>& allowed) const {
    std::string why = "there is no such topic";
    for (const RoledTopic& r : roles_) {
      if (bag_.topics()[r.topic].name != name) continue;
      if (is_one_of(r.role, allowed)) return r.topic;
      why = fmt::format("its messages are {}{}", bag_.topics()[r.topic].type, r.note.empty() ? "" : ", " + r.note);
    }
    throw Error(fmt::format("{}: {}={}: {}; {}", bag_.name(), key, name, why, choices(key, allowed)));
  }

  // The only topic of a role: of images that are there twice, those that are not compressed.
  std::uint32_t only(const char* key, const std::vector<BagRole>& allowed) const {
    std::vector<std::uint32_t> found;
    for (const BagRole role : allowed) {
      if (found.empty()) found = topics_of(role);
    }
    std::vector<std::uint32_t> best;
    for (const std::uint32_t topic : found) {
      const std::string plain = without_transport(name(topic));
      const bool is_there_plain =
          plain != name(topic) && std::any_of(found.begin(), found.end(), [&](std::uint32_t t) { return name(t) == plain; });
      if (!is_there_plain) best.push_back(topic);
    }
    if (best.size() == 1) return best.front();
    if (best.empty()) throw Error(fmt::format("{}: the bag has no {}; {}", bag_.name(), word(key), all()));
    throw Error(fmt::format("{}: the bag has {} topics that could be its {}; {}", bag_.name(), best.size(), word(key),
                            choices(key, allowed)));
  }

  const std::string& name(std::uint32_t topic) const { return bag_.topics()[topic].name; }

  std::vector<std::uint32_t> topics_of(BagRole role) const {
    std::vector<std::uint32_t> topics;
    for (const RoledTopic& r : roles_) {
      if (r.role == role) topics.push_back(r.topic);
    }
    return topics;
  }

 private:
  static bool is_one_of(BagRole role, const std::vector<BagRole>& roles) {
    return std::find(roles.begin(), roles.end(), role) != roles.end();
  }

  static std::string word(std::string_view key) {
    if (key == "depth") return "depth images (16UC1, mono16, 32FC1 or compressedDepth)";
    if (key == "color") return "colour images";
    return std::string(key);
  }

  std::string choices(const char* key, const std::vector<BagRole>& allowed) const {
    const std::string names = names_of(bag_, roles_, allowed);
    return names.empty() ? all() : fmt::format("choose with --topics {}=TOPIC: {}", key, names);
  }

  std::string all() const {
    std::vector<std::string> texts;
    for (const BagTopic& topic : bag_.topics()) texts.push_back(fmt::format("{} ({})", topic.name, topic.type));
    const std::string lost = bag_.left_out().empty() ? "" : fmt::format(" (left out: {})", bag_.left_out().front());
    if (texts.empty()) return fmt::format("it holds no messages{}; record it anew, or copy it again", lost);
    return fmt::format("record them too; its topics: {}{}", fmt::join(texts, ", "), lost);
  }

  const Bag& bag_;
  const std::vector<RoledTopic>& roles_;
};

}  // namespace

bool is_realsense_topic(const std::string& name) {
  return name.starts_with("/device_") && name.find("/sensor_") != std::string::npos;
}

bool is_rectified(const std::string& name) {
  const std::string plain = without_transport(name);
  return plain.find("rect", plain.rfind('/') + 1) != std::string::npos;
}

std::vector<RoledTopic> roles_of(const Bag& bag) {
  std::vector<RoledTopic> roles(bag.topics().size());
  std::vector<bool> is_known(roles.size());
  for (const BagMessage& message : bag.messages()) {
    if (is_known[message.topic]) continue;
    is_known[message.topic] = true;
    const BagTopic& topic = bag.topics()[message.topic];
    try {
      roles[message.topic] = role_of(topic, bag.read(message, kHeadBytes));
    } catch (const Error& e) {
      roles[message.topic].note = e.what();
    }
  }
  for (std::uint32_t i = 0; i < roles.size(); ++i) {
    roles[i].topic = i;
    if (!is_known[i]) roles[i].note = "no messages";
  }
  return roles;
}

std::string_view role_name(BagRole role) {
  switch (role) {
    case BagRole::kDepth:
      return "depth";
    case BagRole::kColor:
    case BagRole::kGrey:
      return "color";
    case BagRole::kInfo:
      return "info";
    case BagRole::kPose:
    case BagRole::kTransforms:
      return "pose";
    case BagRole::kNone:
      break;
  }
  return "";
}

std::string names_of(const Bag& bag, const std::vector<RoledTopic>& roles, const std::vector<BagRole>& wanted) {
  std::vector<std::string> texts;
  for (const RoledTopic& r : roles) {
    if (std::find(wanted.begin(), wanted.end(), r.role) == wanted.end()) continue;
    const BagTopic& topic = bag.topics()[r.topic];
    texts.push_back(fmt::format("{} ({}{})", topic.name, topic.type, r.note.empty() ? "" : ", " + r.note));
  }
  return fmt::format("{}", fmt::join(texts, ", "));
}

BagRoles choose(const Bag& bag, const std::vector<RoledTopic>& roles, const BagChoice& choice) {
  const Chooser chooser(bag, roles);
  const auto pick = [&](const std::string& name, const char* key, const std::vector<BagRole>& allowed) {
    return name.empty() ? chooser.only(key, allowed) : chooser.named(name, key, allowed);
  };
  BagRoles chosen;
  chosen.depth = pick(choice.depth, "depth", {BagRole::kDepth});
  chosen.color = pick(choice.color, "color", {BagRole::kColor, BagRole::kGrey});
  chosen.color_info = info_beside(bag, roles, chooser.name(chosen.color));
  chosen.depth_info = choice.info.empty() ? info_beside(bag, roles, chooser.name(chosen.depth))
                                          : chooser.named(choice.info, "info", {BagRole::kInfo});
  const std::vector<std::uint32_t> infos = chooser.topics_of(BagRole::kInfo);
  if (!chosen.depth_info && infos.size() == 1) {
    chosen.depth_info = infos.front();
    chosen.assumed.push_back(fmt::format("{} is of the depth images {}, since no other CameraInfo is there; --topics info=TOPIC",
                                         chooser.name(infos.front()), chooser.name(chosen.depth)));
  }
  if (!choice.pose.empty()) chosen.pose = chooser.named(choice.pose, "pose", {BagRole::kPose, BagRole::kTransforms});
  return chosen;
}

}  // namespace panoptic
