// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/fusion/object_contacts.h"

#include <algorithm>
#include <map>
#include <unordered_map>

namespace panoptic {
namespace {

// Surface voxels in cells as wide as the reach, so that those near a place are found quickly.
class Cells {
 public:
  explicit Cells(int edge) : edge_(edge) {}

  void add(const SurfaceVoxel& voxel) { cells_[key(voxel, 0, 0, 0)].push_back(&voxel); }

  // The labels other than the voxel's own that are near it.
  void labels_near(const SurfaceVoxel& voxel, std::vector<PanopticId>& labels) const {
    labels.clear();
    for (int n = 0; n < 27; ++n) {
      const auto cell = cells_.find(key(voxel, n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1));
      if (cell == cells_.end()) continue;
      for (const SurfaceVoxel* other : cell->second) {
        if (other->label == voxel.label || std::find(labels.begin(), labels.end(), other->label) != labels.end()) continue;
        if (near(*other, voxel)) labels.push_back(other->label);
      }
    }
  }

 private:
  bool near(const SurfaceVoxel& a, const SurfaceVoxel& b) const {
    std::int64_t squares = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::int64_t d = std::int64_t{a.at[axis]} - b.at[axis];
      squares += d * d;
    }
    return squares <= std::int64_t{edge_} * edge_;
  }

  std::uint64_t key(const SurfaceVoxel& voxel, int dx, int dy, int dz) const {
    constexpr std::uint64_t kBits = 0x1FFFFF;
    const auto cell = [&](std::int32_t c, int d) {
      const std::int32_t below = c >= 0 ? c / edge_ : -((-c + edge_ - 1) / edge_);
      return static_cast<std::uint64_t>(std::int64_t{below} + d) & kBits;
    };
    return cell(voxel.at[2], dz) << 42 | cell(voxel.at[1], dy) << 21 | cell(voxel.at[0], dx);
  }

  int edge_;
  std::unordered_map<std::uint64_t, std::vector<const SurfaceVoxel*>> cells_;
};

}  // namespace

std::vector<Contact> contacts_between(std::span<const PanopticId> ids, const VoxelsByLabel& voxels, const SurfaceVoxels& surface,
                                      int reach) {
  Cells cells(reach);
  for (const PanopticId id : ids) {
    for (const std::uint32_t i : voxels.at(id)) cells.add(surface[i]);
  }
  std::vector<Contact> contacts;
  std::vector<PanopticId> near;
  for (const PanopticId id : ids) {
    const auto& own = voxels.at(id);
    std::map<PanopticId, std::size_t> counts;
    for (const std::uint32_t i : own) {
      cells.labels_near(surface[i], near);
      for (const PanopticId other : near) ++counts[other];
    }
    for (const auto& [other, count] : counts) {
      const std::size_t size = voxels.at(other).size();
      const bool is_smaller = own.size() < size || (own.size() == size && id > other);
      if (is_smaller) contacts.push_back({id, other, static_cast<double>(count) / static_cast<double>(own.size())});
    }
  }
  std::stable_sort(contacts.begin(), contacts.end(), [](const Contact& a, const Contact& b) { return a.share > b.share; });
  return contacts;
}

}  // namespace panoptic
