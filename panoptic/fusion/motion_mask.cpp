// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/motion_mask.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "panoptic/fusion/carving.h"
#include "panoptic/fusion/motion_surface.h"
#include "panoptic/map/space_cells.h"
#include "panoptic/map/voxel_grid.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr int kSamplesAcross = 160;     // of the image: a hand at 3 m is some samples wide
constexpr std::size_t kBands = 16;      // of rows, worked side by side: fixed, so that nothing depends on the thread count
constexpr int kFreeAround = 12;         // of the 27 cells around a point: what moves has been beside it, or was never seen there
constexpr int kSideBySide = 6;          // of the 8 samples around one: borders between near and far smear into free space
constexpr double kLeastArea_m2 = 0.02;  // two hands
constexpr double kGrowth_m = 0.3;       // what stands in free space reaches this far into the rest: feet near the floor
constexpr double kMargin_m = 0.1;       // around a mask
constexpr std::uint16_t kFarSteps = 65535;

// Looks up cells; neighbouring samples lie in the same voxel block.
class CellReader {
 public:
  explicit CellReader(const FreeSpaceMap& space) : space_(space) {}

  int evidence(const CellIndex& cell) {
    const BlockIndex block = block_of(cell);
    if (!known_ || block != block_) {
      block_ = block;
      cells_ = in_range(block) ? space_.cells_of(block) : nullptr;
      known_ = true;
    }
    return cells_ == nullptr ? 0 : evidence_of((*cells_)[static_cast<std::size_t>(number_of(cell))]);
  }

 private:
  const FreeSpaceMap& space_;
  BlockIndex block_;
  const SpaceChunk::Cells* cells_ = nullptr;
  bool known_ = false;
};

CellIndex cell_at(const Vec3d& point_m, double cell_m) {
  const Eigen::Vector3i c = (point_m / cell_m).array().floor().cast<int>();
  return {c.x(), c.y(), c.z()};
}

// Nothing but free space around the cell, as far as it was seen.
bool is_free_around(CellReader& cells, const CellIndex& cell) {
  int free = 0;
  for (int n = 0; n < kNeighbours; ++n) {
    const BlockIndex step = step_to(n);
    free += cells.evidence({cell[0] + step.x, cell[1] + step.y, cell[2] + step.z}) > 0 ? 1 : 0;
  }
  return free >= kFreeAround;
}

bool contains(const MovingThing& box, const Vec3d& point_m) {
  return ((point_m - box.min_m).array() > 0).all() && ((box.max_m - point_m).array() > 0).all();
}

}  // namespace

Fields fields(MovingOptions& o) {
  return {{"classes", &o.classes, "things of a mobile class (label set) are kept out of the map", {}},
          {"points", &o.points, "what comes into space that is known to be free is kept out of the map while it moves", {}},
          {"objects", &o.objects, "objects that were looked through are gone; those that came or were moved are told", {}}};
}

const MovingSight& MotionMask::take_out(const Frame& frame, const Segmentation& segmentation, const PanopticMap& map,
                                        std::span<const MovingThing> expected, RegisteredFrame& registered) {
  sight_.things.clear();
  sight_.mask.clear();
  sight_.cells.clear();
  thing_of_segment_.assign(segmentation.segments.size(), 0);
  for (std::size_t s = 0; options_.classes && s < segmentation.segments.size(); ++s) {
    const Segment& segment = segmentation.segments[s];
    if (!map.labels.is_mobile(segment.class_id) || segment.is_whole_class) continue;
    sight_.things.push_back({.class_id = segment.class_id});
    thing_of_segment_[s] = static_cast<std::uint16_t>(sight_.things.size());
  }
  const bool sees_motion = options_.points && !map.free_space.empty();
  const bool expects = options_.classes && !expected.empty();
  if (sight_.things.empty() && !sees_motion && !expects) return sight_;

  const FrameView view = depth_view(frame, registered);
  sample(view);
  is_behind_.assign(grid_.size(), 0);
  if (!sight_.things.empty()) {
    mark_classes(view, map.voxels, registered);
    find_backgrounds();
  }
  first_guess_ = sight_.things.size();
  if (expects) mark_expected(view, map.voxels, expected);
  end_of_guesses_ = sight_.things.size();
  if (sees_motion) mark_motion(view, map.free_space);
  if (sight_.things.empty()) return sight_;
  class_of_.clear();
  for (const MovingThing& thing : sight_.things) class_of_.push_back(thing.class_id);
  grow(view, map.voxels);
  measure(view, map.free_space.cell_size_m());
  for (std::size_t n = first_guess_; n < end_of_guesses_; ++n) sight_.things[n].class_id = ClassId::kUnknown;
  std::erase_if(sight_.things, [](const MovingThing& thing) { return thing.pixels == 0; });
  take_pixels(view, map.voxels, registered);
  return sight_;
}

void MotionMask::sample(const FrameView& view) {
  const int stride = std::max(1, view.pixels.width / kSamplesAcross);
  grid_.stride = stride;
  grid_.width = (view.pixels.width + stride - 1) / stride;
  grid_.height = (view.pixels.height + stride - 1) / stride;
  grid_.depth.resize(static_cast<std::size_t>(grid_.width) * static_cast<std::size_t>(grid_.height));
  grid_.thing.assign(grid_.size(), 0);
  for (int y = 0; y < grid_.height; ++y) {
    const int v = std::min(y * stride + stride / 2, view.pixels.height - 1);
    for (int x = 0; x < grid_.width; ++x) {
      grid_.depth[grid_.index(x, y)] = view.pixels.depth[view.index(std::min(x * stride + stride / 2, view.pixels.width - 1), v)];
    }
  }
}

Vec3d MotionMask::place_m(const FrameView& view, std::size_t sample) const {
  const auto x = static_cast<int>(sample % static_cast<std::size_t>(grid_.width));
  const auto y = static_cast<int>(sample / static_cast<std::size_t>(grid_.width));
  const int u = std::min(x * grid_.stride + grid_.stride / 2, view.pixels.width - 1);
  const int v = std::min(y * grid_.stride + grid_.stride / 2, view.pixels.height - 1);
  return view.camera_in_world_m + (view.ray(u, v) * grid_.depth[sample]).cast<double>();
}

// Samples whose own pixel is of a mobile segment. Masks reach beyond: what the map has a surface for is not the thing.
void MotionMask::mark_classes(const FrameView& view, const VoxelMap& map, const RegisteredFrame& registered) {
  for (int y = 0; y < grid_.height; ++y) {
    const std::size_t row = registered.index(std::min(y * grid_.stride + grid_.stride / 2, registered.height - 1));
    for (int x = 0; x < grid_.width; ++x) {
      const auto u = static_cast<std::size_t>(std::min(x * grid_.stride + grid_.stride / 2, registered.width - 1));
      const std::uint16_t segment = registered.segment[row + u];
      if (segment == 0 || segment > thing_of_segment_.size() || thing_of_segment_[segment - 1U] == 0) continue;
      const std::size_t i = grid_.index(x, y);
      if (!is_surface(map, place_m(view, i), grid_.depth[i], 1)) grid_.thing[i] = thing_of_segment_[segment - 1U];
    }
  }
}

// Masks reach over the edge of a thing to what is behind it: parts that do not hang together with the main one, and lie deeper
// than all of it. They are no part of the thing, but nobody knows what else they are.
void MotionMask::find_backgrounds() {
  struct Part {
    std::size_t first = 0;  // in queue_
    std::size_t end = 0;
    float nearest_m = 0;
    float farthest_m = 0;
    double area = 0;  // what it would fill at 1 m
  };
  std::vector<std::vector<Part>> parts(sight_.things.size());
  std::vector<bool> taken(grid_.size(), false);
  queue_.clear();
  for (std::size_t i = 0; i < grid_.size(); ++i) {
    const std::uint16_t thing = grid_.thing[i];
    if (thing == 0 || taken[i] || !(grid_.depth[i] > 0)) continue;
    Part part{queue_.size(), 0, grid_.depth[i], grid_.depth[i], 0};
    taken[i] = true;
    queue_.push_back(i);
    for (std::size_t n = part.first; n < queue_.size(); ++n) {
      const float z = grid_.depth[queue_[n]];
      part.nearest_m = std::min(part.nearest_m, z);
      part.farthest_m = std::max(part.farthest_m, z);
      part.area += double{z} * z;
      for_each_beside(queue_[n], [&](std::size_t next) {
        if (grid_.thing[next] != thing || taken[next] || std::abs(grid_.depth[next] - z) > step_m(z)) return;
        taken[next] = true;
        queue_.push_back(next);
      });
    }
    part.end = queue_.size();
    parts[thing - 1U].push_back(part);
  }
  for (const std::vector<Part>& of_thing : parts) {
    const auto main =
        std::max_element(of_thing.begin(), of_thing.end(), [](const Part& a, const Part& b) { return a.area < b.area; });
    for (const Part& part : of_thing) {
      if (part.nearest_m <= main->farthest_m) continue;
      for (std::size_t n = part.first; n < part.end; ++n) {
        is_behind_[queue_[n]] = 1;
        grid_.thing[queue_[n]] = 0;
      }
    }
  }
}

// A mask of a mobile class has a part in the box.
bool MotionMask::was_found(const FrameView& view, const MovingThing& expected) const {
  for (std::size_t i = 0; i < grid_.size(); ++i) {
    if (grid_.thing[i] != 0 && grid_.depth[i] > 0 && contains(expected, place_m(view, i))) return true;
  }
  return false;
}

// No network has seen this frame, or it missed whom those before showed: whatever is where a person must be by now, and no
// surface of the map, is that person.
void MotionMask::mark_expected(const FrameView& view, const VoxelMap& map, std::span<const MovingThing> expected) {
  std::vector<MovingThing> missed;
  for (const MovingThing& thing : expected) {
    if (!was_found(view, thing)) missed.push_back(thing);
  }
  const std::size_t before = sight_.things.size();
  for (const MovingThing& thing : missed) sight_.things.push_back({.class_id = thing.class_id});
  for (std::size_t i = 0; i < grid_.size() && !missed.empty(); ++i) {
    if (!(grid_.depth[i] > 0) || grid_.thing[i] != 0) continue;
    const Vec3d point = place_m(view, i);
    const auto box = std::find_if(missed.begin(), missed.end(), [&](const MovingThing& e) { return contains(e, point); });
    if (box == missed.end() || is_surface(map, point, grid_.depth[i], 1)) continue;
    grid_.thing[i] = static_cast<std::uint16_t>(before + static_cast<std::size_t>(box - missed.begin()) + 1);
  }
}

// Every region of samples in free space is a thing.
void MotionMask::mark_motion(const FrameView& view, const FreeSpaceMap& space) {
  const double cell_m = space.cell_size_m();
  in_free_.assign(grid_.size(), 0);
  parallel_for(kBands, [&](std::size_t band) {
    CellReader cells(space);
    for (std::size_t i = grid_.size() * band / kBands; i < grid_.size() * (band + 1) / kBands; ++i) {
      const float z = grid_.depth[i];
      if (!(z > 0) || grid_.thing[i] != 0) continue;
      const Vec3d point = place_m(view, i);
      const CellIndex cell = cell_at(point, cell_m);
      if (cells.evidence(cell) < kSureViews || !is_free_around(cells, cell)) continue;
      const Vec3d behind = point + (point - view.camera_in_world_m).normalized() * (double{depth_error_m(z)} + cell_m / 2);
      in_free_[i] = cells.evidence(cell_at(behind, cell_m)) > 0 ? 1 : 0;
    }
  });
  std::vector<std::uint8_t> seeds(grid_.size(), 0);
  for (int y = 1; y + 1 < grid_.height; ++y) {
    for (int x = 1; x + 1 < grid_.width; ++x) {
      const std::size_t i = grid_.index(x, y);
      if (in_free_[i] == 0) continue;
      int beside = -1;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) beside += in_free_[grid_.index(x + dx, y + dy)];
      }
      seeds[i] = beside >= kSideBySide ? 1 : 0;
    }
  }
  std::vector<std::size_t> region;
  for (std::size_t i = 0; i < grid_.size(); ++i) {
    if (seeds[i] == 0 || grid_.thing[i] != 0) continue;
    gather_region(i, seeds, region);
    double area_m2 = 0;
    for (const std::size_t r : region) {
      const double edge_m = grid_.stride * double{grid_.depth[r]};
      area_m2 += edge_m * edge_m / (view.camera.fx * view.camera.fy);
    }
    const bool is_thing = area_m2 >= kLeastArea_m2 && sight_.things.size() < kFarSteps - 1;
    if (is_thing) sight_.things.emplace_back();
    for (const std::size_t r : region) {
      seeds[r] = 0;
      if (is_thing) grid_.thing[r] = static_cast<std::uint16_t>(sight_.things.size());
    }
  }
}

// The seeds that are joined with this one.
void MotionMask::gather_region(std::size_t seed, const std::vector<std::uint8_t>& seeds, std::vector<std::size_t>& region) const {
  std::vector<bool> taken(grid_.size(), false);
  region.assign(1, seed);
  taken[seed] = true;
  for (std::size_t n = 0; n < region.size(); ++n) {
    const std::size_t i = region[n];
    for (const std::size_t next :
         {i - 1, i + 1, i - static_cast<std::size_t>(grid_.width), i + static_cast<std::size_t>(grid_.width)}) {
      // Seeds have neighbours on all sides.
      if (seeds[next] == 0 || taken[next] || std::abs(grid_.depth[next] - grid_.depth[i]) > step_m(grid_.depth[i])) continue;
      taken[next] = true;
      region.push_back(next);
    }
  }
}

// Things reach as far as their surface goes on and the map has none there.
void MotionMask::grow(const FrameView& view, const VoxelMap& map) {
  queue_.clear();
  steps_.assign(grid_.size(), 0);
  for (std::size_t i = 0; i < grid_.size(); ++i) {
    if (grid_.thing[i] != 0) queue_.push_back(i);
  }
  for (std::size_t n = 0; n < queue_.size(); ++n) {
    const std::size_t i = queue_[n];
    const float z = grid_.depth[i];
    if (!(z > 0) || is_guess(grid_.thing[i])) continue;
    const ClassId class_id = sight_.things[grid_.thing[i] - 1U].class_id;
    const double farthest = (class_id != ClassId::kUnknown ? kMargin_m : kGrowth_m) * view.camera.fx / (double{z} * grid_.stride);
    if (steps_[i] + 1 > farthest) continue;
    for_each_beside(i, [&](std::size_t next) {
      const float depth = grid_.depth[next];
      if (grid_.thing[next] != 0 || !(depth > 0) || std::abs(depth - z) > step_m(z)) return;
      if (is_surface(map, place_m(view, next), depth, frames_of_surface(class_id))) return;
      grid_.thing[next] = grid_.thing[i];
      steps_[next] = static_cast<std::uint16_t>(steps_[i] + 1);
      queue_.push_back(next);
    });
  }
}

// The boxes of things; those of which no sample is left have no pixels.
void MotionMask::measure(const FrameView& view, float cell_m) {
  constexpr double kFar = std::numeric_limits<double>::max();
  for (MovingThing& thing : sight_.things) thing.min_m = -(thing.max_m = Vec3d::Constant(-kFar));
  for (const std::size_t i : queue_) {
    if (!(grid_.depth[i] > 0)) continue;
    MovingThing& thing = sight_.things[grid_.thing[i] - 1U];
    const Vec3d point = place_m(view, i);
    thing.min_m = thing.min_m.cwiseMin(point);
    thing.max_m = thing.max_m.cwiseMax(point);
    thing.pixels += static_cast<std::size_t>(grid_.stride) * static_cast<std::size_t>(grid_.stride);
    if (thing.class_id == ClassId::kUnknown) sight_.cells.push_back(cell_at(point, double{cell_m}));
  }
  std::sort(sight_.cells.begin(), sight_.cells.end());
  sight_.cells.erase(std::unique(sight_.cells.begin(), sight_.cells.end()), sight_.cells.end());
}

}  // namespace panoptic
