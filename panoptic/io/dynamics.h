// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The truth about a recording in which things move: dynamics.json beside a simulated scan (docs/simulator.md).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/geometry.h"
#include "panoptic/labels.h"

namespace panoptic {

enum class EventKind : std::uint8_t { kRemoved, kMoved, kAdded, kDoor };
const char* name_of(EventKind kind);

// One place of a changed thing: it stood there for frames first to last.
struct TrueStay {
  std::int64_t first_frame = 0;
  std::int64_t last_frame = 0;
  Pose world_from_object = Pose::Identity();
  Eigen::AlignedBox3d box;
  std::optional<EventKind> ended_by;
};

struct TrueThing {
  std::uint16_t instance = 0;
  ClassId class_id = ClassId::kUnknown;
  std::string class_name;
  std::string name;
  std::vector<TrueStay> stays;
};

// How a place was shown: frames that show enough of it, before the change and since, people aside.
struct PlaceViews {
  std::int64_t before = 0;
  std::int64_t after = 0;
  std::optional<std::int64_t> first_after;  // the first frame since the change that shows enough of the place
};

struct TrueChange {
  std::int64_t frame = 0;  // the first one in which it is so
  EventKind kind = EventKind::kRemoved;
  std::uint16_t instance = 0;
  std::string class_name;
  std::optional<Eigen::AlignedBox3d> old_box;
  std::optional<Eigen::AlignedBox3d> new_box;
  PlaceViews old_place;
  PlaceViews new_place;
};

struct TrueMover {
  struct Moment {
    std::int64_t frame = 0;
    std::string activity;
    Eigen::AlignedBox3d box;
  };
  std::uint16_t instance = 0;
  ClassId class_id = ClassId::kUnknown;
  std::string class_name;
  std::vector<Moment> frames;
};

struct DynamicsTruth {
  std::string dynamics;  // people, changes, busy
  double rate_hz = 30;
  std::int64_t frames = 0;
  std::vector<TrueThing> things;
  std::vector<TrueChange> changes;  // in order of time
  std::vector<TrueMover> movers;
};

inline constexpr const char* kDynamicsFile = "dynamics.json";
// The folder of the true masks of what moves, one PNG a frame: 255 = moves.
inline constexpr const char* kMovingFolder = "moving";
// The name of a frame's mask in such a folder: "000012.png".
std::string moving_mask_name(std::int64_t frame);

void write_dynamics(const std::filesystem::path& path, const DynamicsTruth& truth);
// Throws Error naming the file or the value in it that is not as documented.
DynamicsTruth read_dynamics(const std::filesystem::path& path);

}  // namespace panoptic
