// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Bags of ROS 1 and ROS 2 (.bag, .db3, .mcap, or a folder with the parts of one) as recordings: docs/datasets.md. open_recording
// opens them too: by their path where a bag has one topic for each role, else as "PATH?depth=TOPIC,pose=TOPIC".
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/source.h"

namespace panoptic {

// Which topic to take for what; empty: the only one that can be it.
struct BagChoice {
  std::string depth;
  std::string color;
  std::string info;  // the CameraInfo of the depth images
  std::string pose;  // of TF, Odometry, PoseStamped, PoseWithCovarianceStamped or TransformStamped messages

  bool operator==(const BagChoice&) const = default;
};

// The file or folder of a recording by its name: "walk.bag?depth=/d" is walk.bag. What has no such choice, or is there under its
// whole name, is its own path.
std::filesystem::path path_of_recording(const std::string& name);

// "depth=TOPIC,color=TOPIC,info=TOPIC,pose=TOPIC", each part optional. Throws Error for anything else.
BagChoice parse_bag_choice(const std::string& text);

struct ListedTopic {
  std::string name;
  std::string type;  // "sensor_msgs/Image"
  std::uint64_t messages = 0;
  std::string role;  // "depth", "color", "info", "pose"; empty: none
  std::string note;  // the encoding of images and their frame; why it has no role
};

struct BagListing {
  std::string container;
  double begin_s = 0;
  double end_s = 0;
  std::vector<ListedTopic> topics;
  std::vector<std::string> left_out;  // what was damaged or cut off
};

bool is_bag_recording(const std::filesystem::path& path);

// Throws Error if the file cannot be read.
BagListing list_bag(const std::filesystem::path& path);

// The bag as a recording; the other arguments are those of open_recording. Throws Error, naming the topics that there are, if a
// role has no topic or several, if there are no poses (panoptic run --track finds them), and if frames are not connected.
std::unique_ptr<Dataset> open_bag(const std::filesystem::path& path, const BagChoice& choice,
                                  const std::filesystem::path& calibration = {}, std::optional<double> pair_tolerance_s = {});

}  // namespace panoptic
