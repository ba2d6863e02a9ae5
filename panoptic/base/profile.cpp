// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/profile.h"

#include <algorithm>
#include <cmath>

namespace panoptic {
namespace {

constexpr double kShortest_s = 1e-6;
constexpr double kLogBinWidth = 0.02;

}  // namespace

void DurationHistogram::add(double seconds) {
  const double position = std::log(std::max(kShortest_s, seconds) / kShortest_s) / kLogBinWidth;
  bins_[std::min(static_cast<std::size_t>(position), kBins - 1)]++;
  count_++;
  sum_s_ += seconds;
  max_s_ = std::max(max_s_, seconds);
  last_s_ = seconds;
}

void DurationHistogram::add(const DurationHistogram& other) {
  for (std::size_t i = 0; i < kBins; ++i) bins_[i] += other.bins_[i];
  count_ += other.count_;
  sum_s_ += other.sum_s_;
  max_s_ = std::max(max_s_, other.max_s_);
  last_s_ = other.last_s_;
}

double DurationHistogram::mean_ms() const { return count_ == 0 ? 0 : sum_s_ / static_cast<double>(count_) * 1e3; }

double DurationHistogram::percentile_ms(double p) const {
  constexpr double kRounding = 1e-9;  // 0.07 * 100 is a little more than 7
  const double wanted = p * static_cast<double>(count_) * (1 - kRounding);
  std::uint64_t seen = 0;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    seen += bins_[bin];
    if (seen > 0 && static_cast<double>(seen) >= wanted) {
      const double middle_s = kShortest_s * std::exp((static_cast<double>(bin) + 0.5) * kLogBinWidth);
      return std::min(middle_s, max_s_) * 1e3;
    }
  }
  return 0;
}

void Profile::add(std::string_view stage, double seconds) {
  auto found = stages_.find(stage);
  if (found == stages_.end()) found = stages_.emplace(std::string(stage), DurationHistogram{}).first;
  found->second.add(seconds);
}

void Profile::add(const Profile& other) {
  for (const auto& [stage, histogram] : other.stages_) stages_[stage].add(histogram);
}

}  // namespace panoptic
