// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/faults/injection.h"

#include <cstdlib>
#include <sstream>

#include "panoptic/base/files.h"
#include "tests/fresh_folder.h"
#include "tests/places.h"

namespace panoptic::test {

FaultyRun run_with_fault(const std::vector<std::string>& arguments, const std::filesystem::path& below, const Fault& fault,
                         long first) {
  const std::filesystem::path log = fresh_folder("fault_log") / "log";
  const auto in_child = [&] {
    setenv("LD_PRELOAD", interpose_file(), 1);
    setenv("FAULTS_BELOW", below.c_str(), 1);
    setenv("FAULTS_CALLS", fault.calls, 1);
    setenv("FAULTS_ERROR", fault.error == 0 ? "short" : std::to_string(fault.error).c_str(), 1);
    setenv("FAULTS_FROM", std::to_string(first).c_str(), 1);
    setenv("FAULTS_TIMES", std::to_string(fault.times).c_str(), 1);
    setenv("FAULTS_LOG", log.c_str(), 1);
  };
  FaultyRun run{run_program(arguments, in_child), 0, {}};
  for (const std::string& line : lines(is_there(log) ? read_file(log) : "")) {
    std::istringstream words(line);
    std::string kind;
    long number = 0;
    words >> kind >> number;
    std::string path;
    std::getline(words >> std::ws, path);
    if (kind == "calls") {
      run.calls = number;
    } else {
      run.failed_at.push_back(path);
    }
  }
  return run;
}

}  // namespace panoptic::test
