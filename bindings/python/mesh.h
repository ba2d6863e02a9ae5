// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "panoptic/labels.h"
#include "panoptic/mesh.h"

namespace panoptic::python {

// A mesh with the classes that its vertices name.
struct LabelledMesh {
  Mesh mesh;
  LabelSet labels;
};

}  // namespace panoptic::python
