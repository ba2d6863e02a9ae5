// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The 20 classes of ScanNet's benchmark. Wall and floor are stuff, the other 18 are things.
#pragma once

#include <optional>

#include "panoptic/evaluation.h"

namespace panoptic {

// The class's place in benchmark_classes(); nothing for a class that is not among the 20.
std::optional<std::size_t> benchmark_index(ClassId id);

bool is_benchmark_thing(ClassId id);

}  // namespace panoptic
