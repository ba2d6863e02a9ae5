// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/objects/object_contacts.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <tuple>

#include "panoptic/objects/cell_grid.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

struct Box {
  std::array<std::int32_t, 3> low;
  std::array<std::int32_t, 3> high;  // inclusive
};

struct ObjectVoxels {
  LabelSlot id = LabelSlot::kUnknown;
  std::span<const std::uint32_t> voxels;
  Box box;
  bool is_asked = true;
};

Box box_of(std::span<const std::uint32_t> voxels, const SurfaceVoxels& surface) {
  constexpr std::int32_t kFar = std::numeric_limits<std::int32_t>::max();
  Box box{{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}};
  for (const std::uint32_t i : voxels) {
    const SurfaceVoxel voxel = surface[i];
    for (std::size_t a = 0; a < 3; ++a) {
      box.low[a] = std::min(box.low[a], voxel.at[a]);
      box.high[a] = std::max(box.high[a], voxel.at[a]);
    }
  }
  return box;
}

// Are they at most `reach` apart along each axis?
bool near(const Box& a, const Box& b, int reach) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (a.low[axis] - reach > b.high[axis] || b.low[axis] - reach > a.high[axis]) return false;
  }
  return true;
}

// A ball of voxels as rows along x.
class Ball {
 public:
  explicit Ball(int radius) : radius_(radius) {
    for (int squares = radius * radius, width = 0; squares >= 0; --squares) {
      while ((width + 1) * (width + 1) + squares <= radius * radius) ++width;
      half_width_.insert(half_width_.begin(), width);
    }
  }

  int radius() const { return radius_; }
  // At this place along y and z; -1 outside.
  int half_width(int dy, int dz) const {
    const auto squares = static_cast<std::size_t>(dy * dy + dz * dz);
    return squares < half_width_.size() ? half_width_[squares] : -1;
  }

 private:
  int radius_;
  std::vector<int> half_width_;  // by dy^2 + dz^2
};

// The measure of near: within a ball on the grid, which is of voxels or of cells. In voxels, that is at most `most_voxels`.
template <typename Grid>
struct Nearness {
  const Grid& grid;
  Ball ball;
  int most_voxels = 0;
};

template <typename Grid>
bool touches(std::uint32_t voxel, const VoxelSet& others, const Nearness<Grid>& nearness) {
  const Ball& ball = nearness.ball;
  bool found = false;
  nearness.grid.visit_rows(
      voxel, ball.radius(), [&](int dy, int dz) { return ball.half_width(dy, dz); },
      [&](Slot slot, int row, std::uint16_t mask) {
        found = (others.bits(slot, row) & mask) != 0;
        return !found;
      });
  return found;
}

// The voxels of the smaller one that may be near the larger one.
std::vector<std::uint32_t> candidates(const ObjectVoxels& smaller, const Box& larger, const SurfaceVoxels& surface, int reach) {
  std::vector<std::uint32_t> found;
  for (const std::uint32_t i : smaller.voxels) {
    const std::array<std::int32_t, 3> at = surface[i].at;
    if (near({at, at}, larger, reach)) found.push_back(i);
  }
  return found;
}

// Finds the contacts of one object with all smaller ones, in their order.
template <typename Grid>
std::vector<Contact> contacts_of(const ObjectVoxels& larger, std::span<const ObjectVoxels> objects, const SurfaceVoxels& surface,
                                 const Nearness<Grid>& nearness, double min_share) {
  std::vector<Contact> contacts;
  std::optional<VoxelSet> voxels;
  for (const ObjectVoxels& own : objects) {
    const std::size_t size = larger.voxels.size();
    const bool is_smaller = own.voxels.size() < size || (own.voxels.size() == size && own.id > larger.id);
    if (!is_smaller || !(own.is_asked || larger.is_asked)) continue;
    if (!near(own.box, larger.box, nearness.most_voxels)) continue;
    const auto share_of = [&](auto count) { return static_cast<double>(count) / static_cast<double>(own.voxels.size()); };
    const auto some = candidates(own, larger.box, surface, nearness.most_voxels);
    if (share_of(some.size()) <= min_share) continue;
    if (!voxels) voxels.emplace(nearness.grid, larger.voxels);
    const double share =
        share_of(std::count_if(some.begin(), some.end(), [&](std::uint32_t i) { return touches(i, *voxels, nearness); }));
    if (share > min_share) contacts.push_back({own.id, larger.id, share});
  }
  return contacts;
}

template <typename Grid>
std::vector<Contact> all_contacts(std::span<const ObjectVoxels> objects, const SurfaceVoxels& surface,
                                  const Nearness<Grid>& nearness, double min_share) {
  std::vector<std::vector<Contact>> by_object(objects.size());
  parallel_for(objects.size(),
               [&](std::size_t o) { by_object[o] = contacts_of(objects[o], objects, surface, nearness, min_share); });
  std::vector<Contact> contacts;
  for (const auto& own : by_object) contacts.insert(contacts.end(), own.begin(), own.end());
  std::sort(contacts.begin(), contacts.end(), [](const Contact& a, const Contact& b) {
    return std::tuple(-a.share, a.smaller, a.larger) < std::tuple(-b.share, b.smaller, b.larger);
  });
  return contacts;
}

}  // namespace

std::vector<Contact> contacts_between(std::span<const LabelSlot> ids, const VoxelsByLabel& voxels, const SurfaceVoxels& surface,
                                      int reach, double min_share, const std::vector<bool>& asked) {
  const auto is_asked = [&](LabelSlot id) { return asked.empty() || asked[number(id)]; };
  if (ids.size() < 2 || std::none_of(ids.begin(), ids.end(), is_asked)) return {};
  std::vector<ObjectVoxels> objects;
  for (const LabelSlot id : ids) objects.push_back({id, voxels.at(id), box_of(voxels.at(id), surface), is_asked(id)});
  if (reach < kFarReach) return all_contacts(objects, surface, Nearness<SurfaceVoxels>{surface, Ball(reach), reach}, min_share);
  constexpr int kMostCells = kFarReach - 1;
  const int voxels_per_cell = (reach + kMostCells - 1) / kMostCells;
  const int cells = (reach + voxels_per_cell / 2) / voxels_per_cell;
  const CellGrid grid(surface, voxels_per_cell);
  return all_contacts(objects, surface, Nearness<CellGrid>{grid, Ball(cells), (cells + 1) * voxels_per_cell}, min_share);
}

}  // namespace panoptic
