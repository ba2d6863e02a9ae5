// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/panoptic/numbers.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <system_error>

#include "apps/panoptic/arguments.h"

namespace panoptic {

std::vector<double> numbers_from(const std::string& text, std::size_t count, const char* flag, char between) {
  std::vector<double> numbers;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (at < end) {
    double value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || !std::isfinite(value) || (next != end && *next != between)) break;
    numbers.push_back(value);
    if (next + 1 == end) break;  // nothing after the last sign
    at = next == end ? next : next + 1;
  }
  if (at == end && numbers.size() == count) return numbers;
  const char* signs = between == ',' ? "commas" : "colons";
  throw UsageError(fmt::format("{} takes {} numbers with {} between them, not '{}'", flag, count, signs, text));
}

Vec3d point_from(const std::string& text, const char* flag) {
  const std::vector<double> n = numbers_from(text, 3, flag);
  return {n[0], n[1], n[2]};
}

}  // namespace panoptic
