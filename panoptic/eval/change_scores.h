// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Scores of what a run says about a world that moves: things that are gone, new or moved, and pixels that show movers
// (docs/evaluation.md).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/base/json.h"
#include "panoptic/eval/moving_pixels.h"
#include "panoptic/evaluation.h"
#include "panoptic/io/dynamics.h"

namespace panoptic {

// A thing that is gone from a place, new at a place, or moved: then both.
struct PlaceChange {
  std::string class_name;  // NYU40's where it has one
  std::optional<Eigen::AlignedBox3d> old_box;
  std::optional<Eigen::AlignedBox3d> new_box;
  bool counts = true;  // of the truth: it could be seen
};

struct PlaceChanges {
  std::vector<PlaceChange> gone;   // have an old box
  std::vector<PlaceChange> fresh;  // have a new box
  std::vector<PlaceChange> moved;  // have both
};

// A true change counts if the recording showed its place for half a second before and as long again since.
PlaceChanges true_changes(const DynamicsTruth& truth);
// `state`, `moved_from` and `appeared` of objects.json in the folder of a run. Throws Error naming the place; also where the run
// says nothing of states.
PlaceChanges claimed_changes(const std::filesystem::path& folder);

struct ChangeCounts {
  std::uint64_t truths = 0;    // that count
  std::uint64_t found = 0;     // of those
  std::uint64_t claims = 0;    // of the run, right or wrong
  std::uint64_t repeated = 0;  // further claims about what was found: neither right nor wrong, and not among the claims
  std::uint64_t unjudged = 0;  // claims about changes that do not count: likewise

  std::optional<double> precision() const;  // nothing without claims
  std::optional<double> recall() const;     // nothing without truths
  std::optional<double> f1() const;
};

// Pairs claims and truths one to one, the nearest first. A pair has one class (unless `any_class`), and the middle of the
// claimed surface lies in the true box or within 15 cm of it; a moved thing is right at both places.
ChangeCounts count_changes(const std::vector<PlaceChange>& truths, const std::vector<PlaceChange>& claims, bool any_class);

struct ChangeScores {
  ChangeCounts gone;
  ChangeCounts fresh;
  ChangeCounts moved;
  ChangeCounts gone_any_class;
  ChangeCounts fresh_any_class;
  ChangeCounts moved_any_class;
  std::optional<double> ghost_share;   // of the map's surface: farther than 5 cm from the surface at the end
  std::optional<double> completeness;  // of that surface, as far as it was shown: the map within 5 cm
  std::optional<MovingPixels> moving;
};

// `surface`: of the map against the surface at the end.
ChangeScores change_scores(const PlaceChanges& truth, const PlaceChanges& claims, const std::optional<SurfaceScores>& surface);

std::string to_table(const ChangeScores& scores);
Json to_json(const ChangeScores& scores);

}  // namespace panoptic
