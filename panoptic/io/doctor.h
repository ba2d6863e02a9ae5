// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Checks whether a recording is what it claims to be: looks at a sample of frames for the mistakes that ruin most first maps: a
// wrong depth scale, inverted poses, flipped axes, intrinsics of another image size.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "panoptic/base/json.h"
#include "panoptic/source.h"

namespace panoptic {

// In the order of their weight. Assumed: no file says so, and it may be right. Warning: unusual. Failed: a mistake, as far as the
// frames can tell; the map will be rubble. Impossible: no camera is like that, and nothing can be mapped.
enum class Verdict : std::uint8_t { kOk, kAssumed, kWarning, kFailed, kImpossible };

struct Check {
  std::string name;
  Verdict verdict = Verdict::kOk;
  std::string evidence;  // what was measured
  std::string remedy;    // what to do; empty if ok
};

struct DoctorReport {
  std::vector<Check> checks;

  Verdict worst() const;
  std::size_t count(Verdict at_least) const;
};

// Bounds of the work: about (frames + 8 * pairs + 2 * revisits) frames are read, whatever the length of the recording.
struct DoctorOptions {
  std::size_t frames = 100;      // looked at one by one
  std::size_t pairs = 24;        // compared with a later frame
  std::size_t steps = SIZE_MAX;  // from one pose to the next; they cost no images
  std::size_t revisits = 60;     // frames that are compared with those that look at the same place later
};

// The look at a recording before it is mapped: less than a second for images of 640 x 480.
inline constexpr DoctorOptions kPreflight{.frames = 12, .pairs = 8, .steps = 300, .revisits = 0};

// Reads frames on several threads. Of a list of recordings each is looked at by itself, and whether all have the same upward
// direction. Throws only what the dataset throws.
DoctorReport diagnose(const Dataset& dataset, const DoctorOptions& options = {});

// One line a check, "ok      depth scale   ...", with the remedy on a line of its own.
std::string to_text(const DoctorReport& report);
Json to_json(const DoctorReport& report);

}  // namespace panoptic
