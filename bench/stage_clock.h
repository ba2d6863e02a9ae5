// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Processor time, and the time of the mapper's stages between two looks.
#pragma once

#include <ctime>
#include <map>
#include <string>

#include "panoptic/profile.h"

namespace panoptic {

// The process took so much (CLOCK_PROCESS_CPUTIME_ID), or the calling thread did (CLOCK_THREAD_CPUTIME_ID).
inline double cpu_seconds(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_nsec) * 1e-9;
}

class StageClock {
 public:
  // Milliseconds of each stage since the last call, from the mapper's running totals.
  std::map<std::string, double> lap_ms(const Profile& profile) {
    std::map<std::string, double> lap;
    for (const auto& [name, histogram] : profile.stages()) {
      double& before_s = totals_s_[name];
      lap[name] = (histogram.total_s() - before_s) * 1e3;
      before_s = histogram.total_s();
    }
    return lap;
  }

 private:
  std::map<std::string, double> totals_s_;
};

}  // namespace panoptic
