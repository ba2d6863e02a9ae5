// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Labels that are far apart share a column of values. Where no voxel with a label is in reach, that label is as probable as any
// other one that nobody there has seen; so a value has to be kept for the labels near a voxel only, and the column tells by the
// place which label it is about.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "panoptic/crf/bit_grid.h"

namespace panoptic {

class LabelColumns {
 public:
  // `points` in the order of (z, y, x); labels that are not below `label_count` are left out. No voxel is within `reach` voxels,
  // along every axis, of two labels of one column. Labels share columns only if that makes fewer groups of eight of them; else
  // each has its own, in the order of the labels. REQUIRES at least one point, reach > 0.
  LabelColumns(std::span<const GridPoint> points, std::span<const std::uint16_t> labels, std::size_t label_count,
               std::int32_t reach);

  std::size_t count() const { return labels_.size(); }
  bool shared() const { return count() < column_of_.size(); }
  std::uint16_t column_of(std::uint16_t label) const { return column_of_[label]; }
  std::span<const std::uint16_t> columns() const { return column_of_; }  // by label
  // The one label of a column that is in reach of a voxel; the column's first one if none is. REQUIRES one of `points`.
  std::uint16_t label_at(std::size_t column, GridPoint point) const;

 private:
  using TileSet = std::vector<std::uint64_t>;  // a bit a tile

  void share(std::vector<TileSet> regions);

  std::int32_t side_;                               // of a tile, a cube of voxels
  BitGrid tiles_;                                   // those that hold points
  std::vector<std::uint16_t> column_of_;            // by label
  std::vector<std::vector<std::uint16_t>> labels_;  // by column
  std::vector<TileSet> regions_;                    // by label: the tiles in reach; empty if no labels share columns
};

}  // namespace panoptic
