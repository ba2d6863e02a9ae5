// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Checks whether a recording is what it claims to be: looks at a sample of frames for the mistakes that ruin most first maps: a
// wrong depth scale, inverted poses, flipped axes, intrinsics of another image size.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "panoptic/source.h"

namespace panoptic {

enum class Verdict { kOk, kWarning, kFailed };

struct Check {
  std::string name;
  Verdict verdict = Verdict::kOk;
  std::string evidence;  // what was measured
  std::string remedy;    // what to do; empty if ok
};

struct DoctorReport {
  std::vector<Check> checks;

  Verdict worst() const;  // failed if a check failed
};

// Bounds of the work: about (frames + 8 * pairs) frames are read, whatever the length of the recording.
struct DoctorOptions {
  std::size_t frames = 100;  // looked at one by one
  std::size_t pairs = 24;    // compared with a later frame
};

// Reads frames on several threads. Throws only what the dataset throws.
DoctorReport diagnose(const Dataset& dataset, const DoctorOptions& options = {});

// One line a check, "ok      depth scale   ...", with the remedy on a line of its own.
std::string to_text(const DoctorReport& report);

}  // namespace panoptic
