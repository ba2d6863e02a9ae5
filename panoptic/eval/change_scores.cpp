// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/eval/change_scores.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "panoptic/base/json_value.h"
#include "panoptic/error.h"
#include "panoptic/eval/vertex_labels.h"
#include "panoptic/io/category_map.h"

namespace panoptic {
namespace {

constexpr double kShown_s = 0.5;
// Boxes of a map reach a few voxels too far or end where nothing was seen, and some things are flat.
constexpr double kMargin_m = 0.15;
constexpr std::int64_t kMostId = 0xffffffff;

std::string nyu40_or_own(const std::string& name) {
  const std::optional<ClassId> nyu40 = nyu40_of_class_name(name);
  return nyu40 ? std::string(nyu40_name(*nyu40)) : name;
}

// An object of objects.json, as far as it matters here.
struct StatedObject {
  std::string class_name;
  std::string state;
  bool has_appeared = false;
  std::optional<std::uint32_t> moved_from;
  Eigen::AlignedBox3d box;  // moved so that its middle is that of the surface: a few voxels far off shift a box, but not that
};

StatedObject object_in(const JsonValue& entry) {
  StatedObject object;
  object.class_name = nyu40_or_own(entry.at("class").text());
  object.state = entry.at("state").text();
  if (object.state != "present" && object.state != "gone" && object.state != "moved") {
    entry.at("state").wrong("present, gone or moved");
  }
  if (const auto appeared = entry.find("appeared")) object.has_appeared = appeared->boolean();
  if (const auto from = entry.find("moved_from"); from && !from->is_null()) {
    object.moved_from = static_cast<std::uint32_t>(from->integer(0, kMostId));
  }
  if (const JsonValue box = entry.at("box"); !box.is_null()) {
    object.box = {box.at("min_m").point(), box.at("max_m").point()};
  }
  const auto middle = entry.find("centroid_m");
  if (middle && !object.box.isEmpty()) object.box.translate(middle->point() - object.box.center());
  return object;
}

bool is_near(const std::optional<Eigen::AlignedBox3d>& truth, const std::optional<Eigen::AlignedBox3d>& claim) {
  if (!truth || !claim) return truth.has_value() == claim.has_value();
  return truth->exteriorDistance(claim->center()) <= kMargin_m;
}

double apart_m(const PlaceChange& truth, const PlaceChange& claim) {
  double sum_m = 0;
  if (truth.old_box) sum_m += (truth.old_box->center() - claim.old_box->center()).norm();
  if (truth.new_box) sum_m += (truth.new_box->center() - claim.new_box->center()).norm();
  return sum_m;
}

bool is_pair(const PlaceChange& truth, const PlaceChange& claim, bool any_class) {
  return (any_class || truth.class_name == claim.class_name) && is_near(truth.old_box, claim.old_box) &&
         is_near(truth.new_box, claim.new_box);
}

}  // namespace

PlaceChanges true_changes(const DynamicsTruth& truth) {
  const auto shown = [&](const PlaceViews& views) {
    const double least = kShown_s * truth.rate_hz;
    return static_cast<double>(views.before) >= least && static_cast<double>(views.after) >= least;
  };
  PlaceChanges changes;
  for (const TrueChange& change : truth.changes) {
    const std::string name = nyu40_or_own(change.class_name);
    const bool is_old_shown = shown(change.old_place);
    const bool is_new_shown = shown(change.new_place);
    if (change.old_box) changes.gone.push_back({name, change.old_box, std::nullopt, is_old_shown});
    if (change.new_box) changes.fresh.push_back({name, std::nullopt, change.new_box, is_new_shown});
    if (change.old_box && change.new_box) {
      changes.moved.push_back({name, change.old_box, change.new_box, is_old_shown && is_new_shown});
    }
  }
  return changes;
}

PlaceChanges claimed_changes(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "objects.json";
  const Json json = read_json_file(path);
  const JsonValue file(json, path.string());
  std::map<std::uint32_t, StatedObject> objects;
  for (const JsonValue& entry : file.at("objects").elements()) {
    objects.emplace(static_cast<std::uint32_t>(entry.at("id").integer(0, kMostId)), object_in(entry));
  }
  PlaceChanges changes;
  for (const auto& [id, object] : objects) {
    if (object.box.isEmpty()) continue;
    if (object.state != "present") {
      changes.gone.push_back({object.class_name, object.box, std::nullopt});
      continue;
    }
    if (object.has_appeared || object.moved_from) changes.fresh.push_back({object.class_name, std::nullopt, object.box});
    const auto from = object.moved_from ? objects.find(*object.moved_from) : objects.end();
    if (from == objects.end() || from->second.box.isEmpty()) continue;
    changes.moved.push_back({object.class_name, from->second.box, object.box});
  }
  return changes;
}

std::optional<double> ChangeCounts::precision() const {
  return claims == 0 ? std::nullopt : std::optional(static_cast<double>(found) / static_cast<double>(claims));
}

std::optional<double> ChangeCounts::recall() const {
  return truths == 0 ? std::nullopt : std::optional(static_cast<double>(found) / static_cast<double>(truths));
}

std::optional<double> ChangeCounts::f1() const {
  if (truths + claims == 0) return std::nullopt;
  return 2 * static_cast<double>(found) / static_cast<double>(truths + claims);
}

ChangeCounts count_changes(const std::vector<PlaceChange>& truths, const std::vector<PlaceChange>& claims, bool any_class) {
  std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;
  for (std::size_t t = 0; t < truths.size(); ++t) {
    for (std::size_t c = 0; c < claims.size(); ++c) {
      if (is_pair(truths[t], claims[c], any_class)) pairs.emplace_back(apart_m(truths[t], claims[c]), t, c);
    }
  }
  std::sort(pairs.begin(), pairs.end());
  std::vector<bool> is_found(truths.size(), false);
  std::vector<bool> is_right(claims.size(), false);
  for (const auto& [apart, t, c] : pairs) {
    if (is_found[t] || is_right[c]) continue;
    is_found[t] = true;
    is_right[c] = true;
  }
  ChangeCounts counts;
  for (std::size_t t = 0; t < truths.size(); ++t) {
    counts.truths += truths[t].counts ? 1 : 0;
    counts.found += truths[t].counts && is_found[t] ? 1 : 0;
  }
  std::vector<bool> is_about(claims.size(), false);  // a change of the truth
  for (const auto& [apart, t, c] : pairs) is_about[c] = true;
  std::uint64_t wrong = 0;
  for (std::size_t c = 0; c < claims.size(); ++c) {
    wrong += is_about[c] ? 0 : 1;
    counts.repeated += is_about[c] && !is_right[c] ? 1 : 0;
  }
  counts.claims = counts.found + wrong;
  counts.unjudged = claims.size() - counts.claims - counts.repeated;
  return counts;
}

ChangeScores change_scores(const PlaceChanges& truth, const PlaceChanges& claims, const std::optional<SurfaceScores>& surface) {
  ChangeScores scores;
  scores.gone = count_changes(truth.gone, claims.gone, false);
  scores.fresh = count_changes(truth.fresh, claims.fresh, false);
  scores.moved = count_changes(truth.moved, claims.moved, false);
  scores.gone_any_class = count_changes(truth.gone, claims.gone, true);
  scores.fresh_any_class = count_changes(truth.fresh, claims.fresh, true);
  scores.moved_any_class = count_changes(truth.moved, claims.moved, true);
  if (!surface) return scores;
  const ThresholdScores& near = surface->at.front();
  if (near.precision) scores.ghost_share = 1 - *near.precision;
  scores.completeness = near.recall;
  return scores;
}

}  // namespace panoptic
