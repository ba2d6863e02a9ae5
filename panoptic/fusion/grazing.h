// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Finds the pixels in which a frame sees its surface at a grazing angle. The truncation band is measured along the ray, so across
// such a surface it is thin: at a cosine of .15 a band of 4 voxels is .6 voxels thick, and most voxels of the surface lie
// outside.
#pragma once

#include <vector>

#include "panoptic/fusion/integrate_kernels.h"

namespace panoptic {

// How far the band reaches across the surface at least, in voxels: marching cubes needs every corner of a cell that the surface
// passes through, and they lie up to sqrt(3) voxels away from it.
inline constexpr float kLeastAcross_voxels = 2;
// No band becomes longer along the ray than this many times its own length.
inline constexpr float kLongestBand = 4;

// Fills `scale` with a factor per pixel of `frame` and one for "no reading": signed distances along the ray are multiplied by it.
// It is 1 where the band reaches far enough across the surface as it is, where there is no depth, and where the pixels around do
// not lie in one plane, as at the border of an object; else it is as much smaller as the band has to be longer, and not below
// 1 / kLongestBand. Rows run in parallel.
void grazing_scales(const KernelFrame& frame, const Band& band, float voxel_size_m, std::vector<float>& scale);

}  // namespace panoptic
