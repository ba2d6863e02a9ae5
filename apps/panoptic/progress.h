// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Messages on stderr: progress of long work (a bar on a terminal, a line now and then elsewhere), warnings, failures.
#pragma once

#include <cstddef>
#include <string>

#include "panoptic/profile.h"

namespace panoptic {

class Progress {
 public:
  Progress(std::string unit, std::size_t total);
  ~Progress();  // leaves the bar where it is and ends its line
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void advance(std::size_t done);

 private:
  void draw();

  std::string unit_;
  std::size_t total_;
  std::size_t done_ = 0;
  bool terminal_;
  double last_drawn_s_ = -1e9;
  Stopwatch since_start_;
};

// Writes text for a person on stderr. If stderr takes no more there is nobody to tell, and the work goes on.
void tell(const std::string& text);

// True once Ctrl-C was pressed (after watch_for_interrupt); a second Ctrl-C ends the process at once.
void watch_for_interrupt();
bool interrupted();

}  // namespace panoptic
