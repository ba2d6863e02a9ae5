// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The mode "Play" and the slice of distances need this of a map (docs/viewer_protocol.md): its plan, the frames that it was made
// of, and how far the nearest surface is. Made when somebody asks for the first time. One thread at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/distance_field.h"
#include "panoptic/frame.h"
#include "panoptic/map_file.h"
#include "panoptic/mapping/frame_finder.h"
#include "panoptic/planning/scene_plan.h"
#include "panoptic/source.h"

namespace panoptic {

inline constexpr const char* kNoPlay = "figures and distances need a map file: run with --map FILE, then panoptic play FILE";
inline constexpr const char* kNotWhileMapping =
    "distances and the camera view need a map file: run with --map FILE, then panoptic play FILE";

class PlaySource {
 public:
  // A map file; nothing is read before somebody asks. Empty: there is none, and `why_not` says it.
  explicit PlaySource(std::string map_file, std::string why_not = "");
  // A map that grows: figures live in its newest snapshot (LivePlan), and there is nothing of the below.
  static PlaySource of_growing_map();

  bool grows() const { return grows_; }

  // All throw Error where there is no such thing, with the reason; the same reason again every time.
  const ScenePlan& plan();
  std::string distances();                 // JSON: the level slices through the distances, and where they lie
  std::string slice(std::size_t place);    // one of them as PNG
  std::string frames();                    // JSON: the frames of the camera view
  std::string frame(std::size_t place);    // JSON: camera and pose of one of them
  std::string picture(std::size_t place);  // its colour image as JPEG

 private:
  struct Recording {
    std::unique_ptr<Dataset> dataset;
    FrameFinder finder;
    std::vector<FrameRecord> frames;  // those that the map was made of
  };
  struct Distances {
    DistanceField::Values values;
    Pose world_from_grid;
    double cell_m = 0;
    double cap_m = 0;
  };
  // A thing, or the reason why there is none; neither before somebody asked.
  template <typename T>
  struct Once {
    std::optional<T> made;
    std::string why_not;
  };
  template <typename T, typename Make>
  const T& once(Once<T>& thing, const Make& make);
  static Recording opened(const std::string& map_file);
  const Distances& measured();
  const Recording& recording();
  const Frame& read(std::size_t place);

  std::string map_file_;
  std::string why_not_;
  bool grows_ = false;
  Once<ScenePlan> plan_;
  Once<Distances> distances_;
  Once<Recording> recording_;
  std::optional<std::size_t> read_place_;
  Frame frame_;
};

}  // namespace panoptic
