// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/meshing/marching_cubes_table.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "panoptic/error.h"

namespace panoptic {

const std::array<CellEdge, 12> kCellEdges = {
    {{0, 0}, {2, 0}, {4, 0}, {6, 0}, {0, 1}, {1, 1}, {4, 1}, {5, 1}, {0, 2}, {1, 2}, {2, 2}, {3, 2}}};

namespace {

constexpr int kNone = -1;
constexpr int kEdges = 12;

// The corners of each face in counter-clockwise order seen from outside the cell.
constexpr int kFaces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};

int edge_between(int a, int b) {
  const int low = std::min(a, b);
  const int axis = (a ^ b) == 1 ? 0 : (a ^ b) == 2 ? 1 : 2;
  for (int e = 0; e < kEdges; ++e) {
    if (kCellEdges[static_cast<std::size_t>(e)].corner == low && kCellEdges[static_cast<std::size_t>(e)].axis == axis) return e;
  }
  PANOPTIC_ASSERT(false);
  return kNone;
}

bool inside(int pattern, int corner) { return (pattern >> corner & 1) != 0; }

bool on_face(int edge, const int (&face)[4]) {
  for (int i = 0; i < 4; ++i) {
    if (edge_between(face[i], face[(i + 1) % 4]) == edge) return true;
  }
  return false;
}

bool share_a_face(int a, int b) {
  return std::any_of(std::begin(kFaces), std::end(kFaces),
                     [&](const auto& face) { return on_face(a, face) && on_face(b, face); });
}

// On each face, from every edge where the walk around it enters the inside to the edge where that run of inside corners ends.
// An edge is entered on one of its two faces and left on the other, so following these links runs around closed loops.
std::array<int, kEdges> links(int pattern) {
  std::array<int, kEdges> next{};
  next.fill(kNone);
  for (const auto& face : kFaces) {
    for (int i = 0; i < 4; ++i) {
      if (!inside(pattern, face[i]) || inside(pattern, face[(i + 1) % 4])) continue;
      int first = i;
      while (inside(pattern, face[(first + 3) % 4])) first = (first + 3) % 4;
      const int leave = edge_between(face[i], face[(i + 1) % 4]);
      const int enter = edge_between(face[(first + 3) % 4], face[first]);
      next[static_cast<std::size_t>(enter)] = leave;
    }
  }
  return next;
}

// Cuts the polygon loop[begin..end] into triangles without a cut that lies in a face of the cell, where the neighbouring cell
// might make the same cut and four triangles would meet in one edge. False if there is no such way.
bool triangulate(const std::vector<int>& loop, std::size_t begin, std::size_t end, std::vector<CellTriangle>& triangles) {
  if (end - begin < 2) return true;
  for (std::size_t apex = begin + 1; apex < end; ++apex) {
    const bool left_free = apex == begin + 1 || !share_a_face(loop[begin], loop[apex]);
    const bool right_free = apex + 1 == end || !share_a_face(loop[apex], loop[end]);
    if (!left_free || !right_free) continue;
    const std::size_t before = triangles.size();
    triangles.push_back(
        {static_cast<std::uint8_t>(loop[begin]), static_cast<std::uint8_t>(loop[apex]), static_cast<std::uint8_t>(loop[end])});
    if (triangulate(loop, begin, apex, triangles) && triangulate(loop, apex, end, triangles)) return true;
    triangles.resize(before);
  }
  return false;
}

std::vector<CellTriangle> triangles_of(int pattern) {
  std::vector<CellTriangle> triangles;
  std::array<int, kEdges> next = links(pattern);
  for (int start = 0; start < kEdges; ++start) {
    std::vector<int> loop;
    for (int e = start; next[static_cast<std::size_t>(e)] != kNone;) {
      loop.push_back(e);
      e = std::exchange(next[static_cast<std::size_t>(e)], kNone);
    }
    if (loop.empty()) continue;
    [[maybe_unused]] const bool done = triangulate(loop, 0, loop.size() - 1, triangles);
    PANOPTIC_ASSERT(done);
  }
  return triangles;
}

}  // namespace

const std::array<std::vector<CellTriangle>, 256>& cell_triangles() {
  static const auto kTable = [] {
    std::array<std::vector<CellTriangle>, 256> table;
    for (int pattern = 0; pattern < 256; ++pattern) table[static_cast<std::size_t>(pattern)] = triangles_of(pattern);
    return table;
  }();
  return kTable;
}

}  // namespace panoptic
