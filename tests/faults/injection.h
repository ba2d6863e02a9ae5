// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Runs the program while system calls on its files fail (interpose.cpp).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/apps/program.h"

namespace panoptic::test {

// One kind of trouble with a disk.
struct Fault {
  const char* name = "";
  const char* calls = "";  // as FAULTS_CALLS
  int error = 0;           // an errno; 0: reads and writes move only a part
  int times = 1;           // how many calls in a row fail; 0: all that follow
};

struct FaultyRun {
  ProgramResult program;
  long calls = 0;                      // of the kinds of the fault
  std::vector<std::string> failed_at;  // the files of those that failed
};

// The program, while the `first`-th call on files below the folder fails; 0: none does, they are only counted.
FaultyRun run_with_fault(const std::vector<std::string>& arguments, const std::filesystem::path& below, const Fault& fault,
                         long first);

}  // namespace panoptic::test
