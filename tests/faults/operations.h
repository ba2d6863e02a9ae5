// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The operations that the program is asked for while its disk fails, each with the files that were there before and must be
// there after.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tests/faults/injection.h"

namespace panoptic::test {

namespace fs = std::filesystem;

// A file's path below its folder, and its bytes.
using Files = std::map<std::string, std::string>;
Files files_below(const fs::path& folder);

struct Operation {
  std::string name;
  std::vector<std::string> arguments;
  bool reads_frames = false;  // those that cannot be read are skipped and listed, and the run goes on
  bool keeps_map = false;     // with --map: after any failure, --resume must come to the same end
  bool changes_map = false;   // writes a map file in place
  bool by_the_clock = false;  // what it writes is not the same every time
};

// Small inputs, made when an operation first needs them, and a folder `place` that is put back before every run as it was before
// the operation.
class FaultWorld {
 public:
  FaultWorld();

  const fs::path& root() const { return root_; }    // of all files that the program is to read and write
  const fs::path& place() const { return place_; }  // of those that it may change
  Operation operation(const std::string& name);
  static std::vector<std::string> operations();

  void put_back(const Operation& operation) const;

 private:
  Operation described(const std::string& name) const;
  Operation online(const std::string& map) const;
  void make_home();
  void make_map();
  void make_later_map();
  void make_early_end();
  void make_before(const std::string& name);
  std::vector<std::string> run_arguments(const std::string& map) const;

  fs::path root_;
  fs::path given_;
  fs::path before_;
  fs::path place_;
};

// Before and after a run that nothing disturbed.
struct Undisturbed {
  Files before;
  Files files;
  std::string out;
  std::string map;  // map_summary of the map file of the operation
};

// Hash, objects and frames; "no map" if it is not there.
std::string map_summary(const fs::path& path);

// The broken promises after a run of the operation with the fault, a line each; empty if all is as promised.
std::string complaints(const FaultWorld& world, const Operation& operation, const Fault& fault, const FaultyRun& run,
                       const Undisturbed& undisturbed);

}  // namespace panoptic::test
