// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The 20 classes of ScanNet's benchmark. Wall and floor are stuff, the other 18 are things.
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "panoptic/labels.h"

namespace panoptic {

struct BenchmarkClass {
  ClassId id = ClassId::kUnknown;  // NYU40 number
  std::string_view name;
  bool is_thing = true;
};

constexpr std::size_t kBenchmarkClassCount = 20;

// The classes, ascending by id.
const std::array<BenchmarkClass, kBenchmarkClassCount>& benchmark_classes();

// The class's place in that list; nothing for a class that is not among the 20.
std::optional<std::size_t> benchmark_index(ClassId id);

bool is_benchmark_thing(ClassId id);

}  // namespace panoptic
