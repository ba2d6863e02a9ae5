// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/eval/moving_pixels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/error.h"
#include "panoptic/io/dynamics.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr double kCell_m = 0.2;
constexpr double kKnown_s = 1;
constexpr double kRayStep_m = 0.15;
constexpr double kFarthest_m = 5;  // beyond it cameras measure little
constexpr int kPixelStep = 2;
constexpr double kWidest_m = 200;  // of a scene that is cut into cells

struct MaskedFrame {
  ReadResult read;
  Image<std::uint16_t> truth;
  Image<std::uint16_t> claim;  // empty: the run gave none
};

Image<std::uint16_t> read_mask(const std::filesystem::path& path, const Frame& frame) {
  Image<std::uint16_t> mask = read_gray16(path);
  if (!mask.same_size(frame.depth.width(), frame.depth.height())) {
    throw Error(fmt::format("{}: the mask has {} x {} pixels, the frame's depth {} x {}", path.string(), mask.width(),
                            mask.height(), frame.depth.width(), frame.depth.height()));
  }
  return mask;
}

MaskedFrame read_masked(const Dataset& recording, std::size_t position, const std::filesystem::path& truth,
                        const std::filesystem::path& claims) {
  MaskedFrame it{recording.read(position), {}, {}};
  if (!it.read.frame) return it;
  const std::string name = moving_mask_name(it.read.frame->index);
  it.truth = read_mask(truth / name, *it.read.frame);
  if (is_file(claims / name)) it.claim = read_mask(claims / name, *it.read.frame);
  return it;
}

std::optional<double> share(std::uint64_t part, std::uint64_t all) {
  return all == 0 ? std::nullopt : std::optional(static_cast<double>(part) / static_cast<double>(all));
}

}  // namespace

FirstSeen::FirstSeen(const Eigen::AlignedBox3d& box) : origin_(box.min()) {
  if (box.isEmpty() || !(box.sizes().maxCoeff() < kWidest_m)) {
    throw Error(fmt::format("the scene is empty or wider than {} m: its truth is not in metres", kWidest_m));
  }
  cells_ = (box.sizes() / kCell_m).array().ceil().cast<int>().max(1);
  const auto count =
      static_cast<std::size_t>(cells_.x()) * static_cast<std::size_t>(cells_.y()) * static_cast<std::size_t>(cells_.z());
  first_s_.assign(count, std::numeric_limits<double>::infinity());
}

std::optional<std::size_t> FirstSeen::cell_at(const Vec3d& world_point) const {
  const Eigen::Array3d cell = ((world_point - origin_) / kCell_m).array().floor();
  if (!(cell >= 0).all() || !(cell < cells_.cast<double>().array()).all()) return std::nullopt;
  const Eigen::Array3i at = cell.cast<int>();
  return (static_cast<std::size_t>(at.z()) * static_cast<std::size_t>(cells_.y()) + static_cast<std::size_t>(at.y())) *
             static_cast<std::size_t>(cells_.x()) +
         static_cast<std::size_t>(at.x());
}

void FirstSeen::look(const Frame& frame) {
  // Rays are half a cell apart where they are farthest.
  const int step_px = std::max(1, static_cast<int>(kCell_m / 2 * frame.depth_camera.fx / kFarthest_m));
  for (int v = step_px / 2; v < frame.depth.height(); v += step_px) {
    for (int u = step_px / 2; u < frame.depth.width(); u += step_px) {
      const auto depth_m = static_cast<double>(frame.depth(u, v));
      if (!(depth_m > 0)) continue;
      const double end_m = std::min(depth_m, kFarthest_m);
      for (double z = kRayStep_m;; z += kRayStep_m) {
        const double at_m = std::min(z, end_m);
        const auto cell = cell_at(frame.world_from_camera * back_project(frame.depth_camera, u, v, at_m));
        if (cell) first_s_[*cell] = std::min(first_s_[*cell], frame.time_s);
        if (at_m >= end_m) break;
      }
    }
  }
}

std::optional<double> FirstSeen::seconds(const Vec3d& world_point, double now_s) const {
  const auto cell = cell_at(world_point);
  if (!cell || !std::isfinite(first_s_[*cell])) return std::nullopt;
  return now_s - first_s_[*cell];
}

std::optional<double> MovingPixels::precision() const { return share(both, both + claimed_only); }
std::optional<double> MovingPixels::recall() const { return share(both, both + true_only); }
std::optional<double> MovingPixels::f1() const { return share(2 * both, 2 * both + claimed_only + true_only); }

void count_moving(const Frame& frame, const Image<std::uint16_t>& truth, const Image<std::uint16_t>& claim,
                  const FirstSeen& first_seen, MovingPixels& pixels) {
  for (int v = 0; v < frame.depth.height(); v += kPixelStep) {
    for (int u = 0; u < frame.depth.width(); u += kPixelStep) {
      const bool is_true = truth(u, v) != 0;
      const bool is_claimed = claim(u, v) != 0;
      const auto depth_m = static_cast<double>(frame.depth(u, v));
      if ((!is_true && !is_claimed) || !(depth_m > 0)) continue;
      const Vec3d point = frame.world_from_camera * back_project(frame.depth_camera, u, v, depth_m);
      const auto known_s = first_seen.seconds(point, frame.time_s);
      if (!known_s || *known_s < kKnown_s) continue;
      pixels.both += is_true && is_claimed ? 1 : 0;
      pixels.claimed_only += is_claimed && !is_true ? 1 : 0;
      pixels.true_only += is_true && !is_claimed ? 1 : 0;
    }
  }
  ++pixels.frames;
}

MovingPixels score_moving(const Dataset& recording, const std::filesystem::path& truth, const std::filesystem::path& claims,
                          const Eigen::AlignedBox3d& box) {
  constexpr std::size_t kBatch = 32;  // frames in memory
  FirstSeen first_seen(box);
  MovingPixels pixels;
  for (std::size_t begin = 0; begin < recording.size(); begin += kBatch) {
    std::vector<MaskedFrame> frames(std::min(kBatch, recording.size() - begin));
    parallel_for(frames.size(), [&](std::size_t i) { frames[i] = read_masked(recording, begin + i, truth, claims); });
    for (const MaskedFrame& it : frames) {
      if (!it.read.frame) continue;
      first_seen.look(*it.read.frame);
      if (it.claim.empty()) {
        ++pixels.without_mask;
        continue;
      }
      count_moving(*it.read.frame, it.truth, it.claim, first_seen, pixels);
    }
  }
  if (pixels.frames == 0) {
    throw Error(fmt::format("{}: no mask of any frame of the recording, like {}; name the folder of run --write-moving",
                            claims.string(), moving_mask_name(0)));
  }
  return pixels;
}

}  // namespace panoptic
