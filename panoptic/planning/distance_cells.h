// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The exact distance of every cell of a box to the nearest cell of a set, up to a reach. It is separable (Felzenszwalb and
// Huttenlocher 2012): the distance along x within a row, then the least over each column along y, then along z. The three
// stages are kept, so that after a change only rows and columns are worked out again whose input changed: the result is the
// same as from scratch.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace panoptic {

using Cell = Eigen::Vector3i;

// Cells low to low + size - 1 along each axis; x runs fastest.
struct CellBox {
  Cell low = Cell::Zero();
  Cell size = Cell::Zero();

  std::size_t count() const;
  bool contains(const Cell& cell) const;
  bool contains(const CellBox& other) const;
  // REQUIRES contains(cell)
  std::size_t index(const Cell& cell) const {
    const auto place = [&](int axis) { return static_cast<std::size_t>(cell[axis] - low[axis]); };
    return place(0) + static_cast<std::size_t>(size[0]) * (place(1) + static_cast<std::size_t>(size[1]) * place(2));
  }
};

class DistanceCells {
 public:
  static constexpr std::uint16_t kFar = 65535;
  static constexpr int kMostReach = 250;

  // Distances beyond `reach` cells are kFar. REQUIRES 1 <= reach <= kMostReach.
  explicit DistanceCells(int reach);

  // Makes the box hold these cells, and more beside them, so that it seldom has to grow. Throws Error if it becomes too large.
  void cover(const CellBox& box);
  const CellBox& box() const { return box_; }

  // Adds a member of the set, or takes it out; a cell may be added several times. REQUIRES a cell of the box, added before it
  // is taken out.
  void add(const Cell& cell);
  void remove(const Cell& cell);
  bool holds(const Cell& cell) const { return members_[box_.index(cell)] > 0; }

  // Brings the distances up to date. Returns how many cells have another one now.
  std::size_t update();
  // The squared distance between the centres, in cells, as of the last update.
  std::uint16_t squared(const Cell& cell) const { return result_[box_.index(cell)]; }

 private:
  // The rows y of a slice (one z) that the stage has to look at.
  struct ChangedSlice {
    std::vector<std::uint8_t> rows;
    bool any = false;
  };

  void mark(const Cell& cell);
  void resize(const CellBox& box);
  void update_slice(int z);
  bool update_row(std::size_t begin, std::vector<std::uint8_t>& fresh);
  void update_along_y(int z, int x, int first, int last);
  std::size_t update_along_z(int y);
  std::size_t write_column(int x, int y, const std::vector<int>& fresh, int begin);

  int reach_;
  CellBox box_;
  std::vector<std::uint16_t> members_;  // how often each cell was added
  std::vector<std::uint8_t> along_x_;   // cells to the nearest member of the row; 255: beyond the reach
  std::vector<std::uint16_t> along_y_;  // squared, within the slice
  std::vector<std::uint16_t> result_;
  std::vector<std::uint8_t> touched_;  // along_y_ changed there in this update
  std::vector<ChangedSlice> slices_;   // by z
};

}  // namespace panoptic
