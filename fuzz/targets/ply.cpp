// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "fuzz/input.h"
#include "panoptic/io/scan_ply.h"
#include "panoptic/outputs.h"

namespace panoptic::fuzz {
namespace {

template <typename Triangles>
void require_corners(const Triangles& triangles, std::size_t vertices) {
  for (const auto& triangle : triangles) {
    for (const std::uint32_t corner : triangle) require(corner < vertices, "faces are made of vertices that exist");
  }
}

}  // namespace

void ply(Input input) {
  static const Scratch kScratch("ply");
  const std::filesystem::path path = kScratch.put("a.ply", input);
  succeeds([&] {
    const Mesh mesh = read_ply(path);
    require_corners(mesh.triangles, mesh.vertices.size());
  });
  succeeds([&] {
    ScanTruth scan;
    read_scan_ply(path, scan);
    require(scan.colors.size() == scan.positions.size(), "every vertex has a colour");
    require_corners(scan.triangles, scan.positions.size());
  });
}

}  // namespace panoptic::fuzz
