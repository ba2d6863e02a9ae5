// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A recording whose tracker drifts, its true poses, and maps of it.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "panoptic/mapping/checkpoint.h"
#include "panoptic/mapping/mapper_parts.h"
#include "tests/mapping/two_balls.h"

namespace panoptic::test {

namespace drifting {

inline constexpr int kFrames = 30;

// Two balls on a table top, seen from an orbit. Labels waver as those of networks do; every fifth frame has none.
inline Frame true_frame(int i) {
  static const std::vector<Frame> kAll = [] {
    std::vector<Frame> frames;
    for (int k = 0; k < kFrames; ++k) frames.push_back(two_balls(0.2 * k, 3 * k));
    return frames;
  }();
  return kAll[static_cast<std::size_t>(i)];
}

inline Segmentation segmentation_of(int i) { return i % 5 == 3 ? Segmentation{} : wavering(true_frame(i), 8); }

// Drift that grows to half a metre: the second round sees everything twice.
inline Pose drifted(int i) {
  const Pose truth = true_frame(i).world_from_camera;
  const double share = static_cast<double>(i) / kFrames;
  Pose drift = Pose::Identity();
  drift.translation() = Vec3d(0.5, 0.05, -0.3) * share;
  drift.linear() = Eigen::AngleAxisd(0.1 * share, Vec3d::UnitY()).toRotationMatrix();
  return drift * truth;
}

inline Frame drifted_frame(int i) {
  Frame frame = true_frame(i);
  frame.time_s = 0.1 * i;
  frame.world_from_camera = drifted(i);
  return frame;
}

inline std::vector<PoseUpdate> true_poses(int end = kFrames) {
  std::vector<PoseUpdate> poses;
  for (int i = 0; i < end; ++i) poses.push_back({3 * i, true_frame(i).world_from_camera});
  return poses;
}

inline ReadResult read_again(std::int64_t frame) { return {drifted_frame(static_cast<int>(frame / 3)), {}}; }

inline Options often() {
  Options options;
  options.objects.every_frames = 4;
  options.regularizer.every_frames = 7;
  options.map.log = "reference";
  options.map.voxel_size_m = 0.04F;
  return options;
}

inline void add_frames(Mapper& mapper, int begin = 0, int end = kFrames) {
  for (int i = begin; i < end; ++i) ASSERT_EQ(mapper.add(drifted_frame(i), segmentation_of(i)), Outcome{});
}

struct Hashes {
  std::uint64_t voxels = 0;
  std::uint64_t free_space = 0;
  bool operator==(const Hashes&) const = default;
};
inline Hashes hashes_of(const PanopticMap& map) { return {map.voxels.hash(), map.free_space.hash()}; }

// A recording with the poses of a drifting tracker; every seventh position cannot be read.
class Drifting : public Dataset {
 public:
  std::string description() const override { return "drifting"; }
  std::size_t size() const override { return kFrames; }
  ReadResult read(std::size_t position) const override {
    const auto i = static_cast<int>(position);
    if (i % 7 == 6) return {std::nullopt, {3 * i, "unreadable"}};
    return {drifted_frame(i), {}};
  }
};

// The log keeps depth and colour.
inline Options copying() {
  Options options = often();
  options.map.log = "copy";
  return options;
}

inline RunIdentity identity(const Options& options = often()) { return {"somewhere", "", "", options}; }

// Maps the recording up to a position with a map file, corrected once on the way if there are `poses`.
inline std::unique_ptr<Mapper> map_to_file(const std::filesystem::path& path, std::size_t end, bool complete,
                                           std::optional<std::size_t> correct_at = std::nullopt,
                                           const Options& options = often()) {
  auto mapper = std::make_unique<Mapper>(options, test_labels());
  Checkpoints checkpoints({.path = path, .resume = true, .every_s = 0}, identity(options), *mapper);
  for (std::size_t position = checkpoints.positions(); position < end; ++position) {
    const ReadResult read = Drifting().read(position);
    if (read.frame) {
      const Segmentation s = segmentation_of(static_cast<int>(position));
      checkpoints.note(record_of(*read.frame, !s.segments.empty(), mapper->add(*read.frame, s)));
    } else {
      mapper->skip(read.skipped);
      checkpoints.note({.frame = read.skipped.index, .unused_because = read.skipped.reason});
    }
    if (position + 1 == correct_at) mapper->update_poses(true_poses(static_cast<int>(position) + 1), read_again);
    checkpoints.after_frame(*mapper);
  }
  if (complete) mapper->finish();
  checkpoints.finish(*mapper, complete);
  return mapper;
}

}  // namespace drifting

}  // namespace panoptic::test
