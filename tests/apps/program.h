// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Runs the panoptic program as a user does, and writes recordings for it.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "panoptic/base/json.h"
#include "panoptic/frame.h"

namespace panoptic::test {

struct ProgramResult {
  int exit_code = -1;  // 128 + signal if it was killed
  std::string out;
  std::string err;
};

// A program that was started; its output grows in the two files.
struct RunningProgram {
  int pid = 0;
  std::filesystem::path out;
  std::filesystem::path err;
};

// `in_child` runs in the child before the program starts (limits, signals), `while_running` in the parent.
ProgramResult run_program(const std::vector<std::string>& arguments, const std::function<void()>& in_child = {},
                          const std::function<void(const RunningProgram&)>& while_running = {});

// Several programs that start at the same moment.
std::vector<ProgramResult> run_at_once(const std::vector<std::vector<std::string>>& programs);

// Waits until the text is in the file; false if the program ended first.
bool wait_for_text(const RunningProgram& program, const std::filesystem::path& file, const std::string& text);

// Fills the empty folder with files by `make`, or with copies of what it made for this `name` earlier in the process.
void fill_once(const std::filesystem::path& folder, const std::string& name, const std::function<void()>& make);

// A ball on a floor, seen from an orbit, as a 7-Scenes recording in the folder.
void write_orbit_recording(const std::filesystem::path& folder, int frames);
Frame orbit_frame(int index);

std::vector<std::string> lines(const std::string& text);

}  // namespace panoptic::test
