// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Memory of the process. All functions may be called from any thread.
#pragma once

#include <cstddef>

namespace panoptic {

// In memory now: its own pages and those of files.
std::size_t resident_bytes();

// Gives the free parts of the heap back to the system: for when much was freed and will not be asked for soon.
void give_back_free_memory();

// Memory that map.memory_limit_mb does not bound: that of networks.
std::size_t left_out_of_limit();

// Adds to it what is resident more at its end than at its beginning.
class LeftOutOfLimit {
 public:
  LeftOutOfLimit() : before_(resident_bytes()) {}
  ~LeftOutOfLimit();
  LeftOutOfLimit(const LeftOutOfLimit&) = delete;
  LeftOutOfLimit& operator=(const LeftOutOfLimit&) = delete;

 private:
  std::size_t before_;
};

}  // namespace panoptic
