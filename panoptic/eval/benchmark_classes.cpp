// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/eval/benchmark_classes.h"

#include <algorithm>

#include "panoptic/io/category_map.h"

namespace panoptic {

const std::array<BenchmarkClass, kBenchmarkClassCount>& benchmark_classes() {
  static const auto kClasses = [] {
    constexpr std::array<std::uint16_t, kBenchmarkClassCount> kIds = {1,  2,  3,  4,  5,  6,  7,  8,  9,  10,
                                                                      11, 12, 14, 16, 24, 28, 33, 34, 36, 39};
    constexpr std::uint16_t kLastStuff = 2;
    std::array<BenchmarkClass, kBenchmarkClassCount> classes;
    std::transform(kIds.begin(), kIds.end(), classes.begin(), [](std::uint16_t n) {
      return BenchmarkClass{ClassId{n}, nyu40_name(ClassId{n}), n > kLastStuff};
    });
    return classes;
  }();
  return kClasses;
}

std::optional<std::size_t> benchmark_index(ClassId id) {
  const auto& classes = benchmark_classes();
  const auto* at =
      std::lower_bound(classes.begin(), classes.end(), id, [](const BenchmarkClass& c, ClassId i) { return c.id < i; });
  if (at == classes.end() || at->id != id) return std::nullopt;
  return static_cast<std::size_t>(at - classes.begin());
}

bool is_benchmark_thing(ClassId id) {
  const std::optional<std::size_t> index = benchmark_index(id);
  return index && benchmark_classes()[*index].is_thing;
}

}  // namespace panoptic
