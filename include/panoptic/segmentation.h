// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The networks' findings in one frame, and their fusion to panoptic labels per pixel (Eq. 1).
#pragma once

#include <cstdint>
#include <vector>

#include "panoptic/image.h"
#include "panoptic/labels.h"
#include "panoptic/options.h"
#include "panoptic/outcome.h"

namespace panoptic {

struct ClassProbability {
  ClassId class_id = ClassId::kUnknown;
  float probability = 0;

  bool operator==(const ClassProbability&) const = default;
};

// A region of one frame: one object (thing) or all pixels of one stuff class.
struct Segment {
  ClassId class_id = ClassId::kUnknown;  // of the mapper's label set, or kUnknown
  float score = 1;                       // p(z, O) in Eq. 12, 0 to 1; 1 for stuff
  // p(z, l | O) over classes of the label set, sorted by class id, with a sum of at most 1; empty = class_id alone.
  std::vector<ClassProbability> class_probabilities;
  bool is_whole_class = false;  // things that were not told apart: what class is there is known, which one is not

  bool operator==(const Segment&) const = default;
};

// Panoptic labels L^Pa of one frame at the size of the colour image: segment_at holds 0 for unknown, else 1 + the index of
// the segment. Empty image: the frame has no prediction, and its labels are not integrated.
struct Segmentation {
  Image<std::uint16_t> segment_at;
  std::vector<Segment> segments;

  bool operator==(const Segmentation&) const = default;
};

// One detected instance at the size of the colour image: the mask's pixels within [x0, x0 + mask.width) x [y0, ...).
struct Instance {
  Segment segment;
  int x0 = 0;
  int y0 = 0;
  Image<std::uint8_t> mask;  // nonzero = object
};

// Eq. 1: instance first, else the semantic class, else unknown. `semantic` holds class numbers of the label set at the size of
// the colour image. Instances that keep no pixel, whose class is no thing of the label set, or whose score is NaN are dropped.
// Where masks overlap, ties go to the higher score, then to the earlier one. Segments: instances from front to back, then
// whole classes.
Segmentation fuse(const Image<ClassId>& semantic, const std::vector<Instance>& instances, const LabelSet& labels,
                  const SegmentationOptions& options = {});

// Whether a segmentation can be used with a colour image of this size, and in a map with these classes.
Outcome check(const Segmentation& segmentation, int width, int height);
Outcome check_classes(const Segmentation& segmentation, const LabelSet& labels);

}  // namespace panoptic
