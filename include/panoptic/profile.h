// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Stage times in constant memory: a million frames take no more room than one.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace panoptic {

// Durations in logarithmic bins of 2 %, from 1 us to about 1000 s: percentiles are exact within 1 %.
class DurationHistogram {
 public:
  void add(double seconds);
  void add(const DurationHistogram& other);  // all of its durations; what was last there is the last one

  std::uint64_t count() const { return count_; }
  double mean_ms() const;
  double max_ms() const { return max_s_ * 1e3; }
  double last_ms() const { return last_s_ * 1e3; }
  double total_s() const { return sum_s_; }
  // The duration that a share p (0..1) of the samples does not exceed. 0 without samples.
  double percentile_ms(double p) const;

 private:
  static constexpr std::size_t kBins = 1050;
  std::array<std::uint64_t, kBins> bins_{};
  std::uint64_t count_ = 0;
  double sum_s_ = 0;
  double max_s_ = 0;
  double last_s_ = 0;
};

// Named stages. Not thread-safe: one writer.
class Profile {
 public:
  void add(std::string_view stage, double seconds);
  void add(const Profile& other);
  const std::map<std::string, DurationHistogram, std::less<>>& stages() const { return stages_; }

 private:
  std::map<std::string, DurationHistogram, std::less<>> stages_;
};

class Stopwatch {
 public:
  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

// The most memory that this process has held, and what it holds now, in MB (1e6 bytes).
double peak_rss_mb();
double rss_mb();

}  // namespace panoptic
