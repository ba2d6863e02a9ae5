// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace panoptic {

// The steps that an export of a YOLO with masks has done itself already.
enum class YoloForm {
  kHeads,           // nothing: per stride, distributions of the sides of boxes, classes and coefficients
  kRaw,             // boxes: centre, size, classes, coefficients (versions 8, 11 and later)
  kRawWithObjects,  // the same with the probability of an object before the classes (versions 5 and 7)
  kSuppressed,      // non-maximum suppression: corners, score, class number, coefficients
};

}  // namespace panoptic
