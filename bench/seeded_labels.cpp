// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/seeded_labels.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "panoptic/sim/random.h"

namespace panoptic {
namespace {

enum Purpose : std::uint64_t { kSite = 1, kKind, kMissed };

constexpr double kStuffShare = 0.35;  // of the cells
constexpr double kMissedShare = 0.1;  // of the things in each frame
constexpr int kPatch_px = 4;          // labels change in patches of this many colour pixels

struct Cell {
  std::int64_t x, y, z;
  std::uint64_t key() const {
    return hash_bits(static_cast<std::uint64_t>(x), static_cast<std::uint64_t>(y), static_cast<std::uint64_t>(z));
  }
};

// The cell whose jittered centre is nearest: a Voronoi division of the world, so that borders cut surfaces at any angle.
std::uint64_t nearest_site(const Vec3d& point, const SeededLabels& settings) {
  const Vec3d scaled = point / settings.cell_m;
  const Vec3d low = scaled.array().floor();
  std::uint64_t best_key = 0;
  double best = 1e9;
  for (int n = 0; n < 27; ++n) {
    const Cell cell{static_cast<std::int64_t>(low.x()) + n % 3 - 1, static_cast<std::int64_t>(low.y()) + n / 3 % 3 - 1,
                    static_cast<std::int64_t>(low.z()) + n / 9 - 1};
    Random random(settings.seed, kSite, cell.key());
    const Vec3d site = Vec3d(static_cast<double>(cell.x), static_cast<double>(cell.y), static_cast<double>(cell.z)) +
                       Vec3d(random.uniform(), random.uniform(), random.uniform());
    const double distance = (site - scaled).squaredNorm();
    if (distance < best) {
      best = distance;
      best_key = cell.key();
    }
  }
  return best_key;
}

// Gives segments their numbers as their sites turn up.
class SegmentTable {
 public:
  SegmentTable(const LabelSet& labels, std::uint64_t seed, std::int64_t frame) : seed_(seed), frame_(frame) {
    for (const LabelClass& c : labels.classes()) (c.is_thing ? things_ : stuff_).push_back(c.id);
  }

  std::uint16_t number_of(std::uint64_t site) {
    Random kind(seed_, kKind, site);
    const bool is_stuff = kind.chance(kStuffShare);
    const ClassId class_id = kind.pick(is_stuff ? stuff_ : things_);
    if (!is_stuff && Random(seed_, kMissed, hash_bits(site, static_cast<std::uint64_t>(frame_))).chance(kMissedShare)) return 0;
    const std::uint64_t key = is_stuff ? panoptic::number(class_id) : site;  // stuff is one segment per class
    const auto [place, is_new] = numbers_.try_emplace(key, static_cast<std::uint16_t>(segments_.size() + 1));
    if (is_new) segments_.push_back(is_stuff ? Segment{class_id, 1, {}} : Segment{class_id, 0.8F, {{class_id, 1.0F}}});
    return place->second;
  }

  std::vector<Segment> take() { return std::move(segments_); }

 private:
  std::uint64_t seed_;
  std::int64_t frame_;
  std::vector<ClassId> things_;
  std::vector<ClassId> stuff_;
  std::map<std::uint64_t, std::uint16_t> numbers_;
  std::vector<Segment> segments_;
};

// Where the colour camera sees a depth pixel, in patches; nothing outside the image.
std::optional<std::pair<int, int>> patch_of(const Frame& frame, const Vec3d& in_depth_camera) {
  const Vec3d p = frame.color_from_depth * in_depth_camera;
  const Camera& c = frame.color_camera;
  if (p.z() <= 0) return std::nullopt;
  const double u = std::floor(c.fx * p.x() / p.z() + c.cx + 0.5);
  const double v = std::floor(c.fy * p.y() / p.z() + c.cy + 0.5);
  if (!(u >= 0 && v >= 0 && u < c.width && v < c.height)) return std::nullopt;
  return std::pair{static_cast<int>(u) / kPatch_px, static_cast<int>(v) / kPatch_px};
}

// The site of each patch, from one depth pixel in four; patches that none falls on repeat their left neighbour (0 = none yet).
Image<std::uint64_t> site_patches(const Frame& frame, const SeededLabels& settings) {
  constexpr int kStride_px = 2;
  Image<std::uint64_t> sites((frame.color.width() + kPatch_px - 1) / kPatch_px,
                             (frame.color.height() + kPatch_px - 1) / kPatch_px, 0);
  for (int v = 0; v < frame.depth.height(); v += kStride_px) {
    for (int u = 0; u < frame.depth.width(); u += kStride_px) {
      const float z = frame.depth(u, v);
      if (!(z > 0 && z < 100)) continue;
      const Vec3d point = back_project(frame.depth_camera, u, v, double{z});
      const auto patch = patch_of(frame, point);
      if (!patch) continue;
      std::uint64_t& site = sites(patch->first, patch->second);
      if (site == 0) site = nearest_site(frame.world_from_camera * point, settings);
    }
  }
  for (std::size_t i = 1; i < sites.size(); ++i) {
    if (sites[i] == 0) sites[i] = sites[i - 1];
  }
  return sites;
}

}  // namespace

Segmentation seeded_labels(const Frame& frame, const LabelSet& labels, const SeededLabels& settings) {
  const Image<std::uint64_t> sites = site_patches(frame, settings);
  SegmentTable table(labels, settings.seed, frame.index);
  Image<std::uint16_t> numbers(sites.width(), sites.height(), 0);
  for (std::size_t i = 0; i < sites.size(); ++i) {
    if (sites[i] != 0) numbers[i] = table.number_of(sites[i]);
  }
  Segmentation result{Image<std::uint16_t>(frame.color.width(), frame.color.height()), table.take()};
  for (int v = 0; v < result.segment_at.height(); ++v) {
    for (int u = 0; u < result.segment_at.width(); ++u) {
      result.segment_at(u, v) = numbers(u / kPatch_px, v / kPatch_px);
    }
  }
  return result;
}

}  // namespace panoptic
