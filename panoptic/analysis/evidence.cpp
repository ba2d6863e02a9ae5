// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/evidence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <utility>
#include <vector>

#include "panoptic/error.h"

namespace panoptic {
namespace {

// Survivors may have been merged themselves. No chain is longer than the list, unless it bites its tail.
PanopticId survivor_of(PanopticId id, const std::map<PanopticId, PanopticId>& into) {
  for (std::size_t step = 0; step < into.size(); ++step) {
    const auto next = into.find(id);
    if (next == into.end()) break;
    id = next->second;
  }
  return id;
}

[[noreturn]] void no_such_object(const std::filesystem::path& run, PanopticId id, const std::vector<RunObject>& objects) {
  const std::int64_t asked = number(id);
  if (objects.empty()) throw Error(fmt::format("{}: the map has no objects, so none has the id {}", run.string(), asked));
  const auto [least, most] = std::ranges::minmax_element(objects, {}, &RunObject::id);
  const auto distance = [&](const RunObject& object) { return std::abs(number(object.id) - asked); };
  const auto nearest = std::ranges::min_element(objects, {}, distance);
  throw Error(fmt::format("{}: no object has the id {}; there are {} from {} to {}, the nearest is {}", run.string(), asked,
                          objects.size(), number(least->id), number(most->id), number(nearest->id)));
}

std::string counts_text(const std::vector<std::pair<std::string, std::uint64_t>>& counts) {
  std::string text;
  for (const auto& [name, count] : counts) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name, count);
  return text;
}

std::string votes_text(const RunObject& o) {
  if (o.votes.empty()) return "  votes          not written down by this run\n";
  std::string text = fmt::format("  votes          in stretches of {} frames, from frame\n", o.frames_per_bin);
  for (const RunObject::Votes& v : o.votes) text += fmt::format("    {:>9}    {}\n", v.first_frame, counts_text(v.of_class));
  return text;
}

std::string views_text(const RunObject& o) {
  if (o.best_views.empty()) return "  best frames    not written down by this run\n";
  std::string text = "  best frames    as, score, visible pixels, box in the colour image\n";
  for (const RunObject::View& v : o.best_views) {
    text += fmt::format("    {:>9}    {} {:.2f}, {} px, ({}, {}) to ({}, {})\n", v.frame, v.class_name, v.score, v.visible_px,
                        v.box.u0, v.box.v0, v.box.u1, v.box.v1);
  }
  return text;
}

}  // namespace

Evidence read_evidence(const std::filesystem::path& run, PanopticId id) {
  const RunObjects all = read_run_objects(run);
  const auto object = std::ranges::find(all.objects, survivor_of(id, all.merged_into), &RunObject::id);
  if (object == all.objects.end()) no_such_object(run, id, all.objects);
  return {id, *object};
}

std::string to_text(const Evidence& evidence) {
  const RunObject& o = evidence.object;
  std::string text;
  if (evidence.asked_id != o.id) text += fmt::format("object {} became part of {}\n", number(evidence.asked_id), number(o.id));
  text += fmt::format("{} {}\n  probabilities  ", o.class_name, number(o.id));
  for (std::size_t i = 0; i < o.probabilities.size(); ++i) {
    text += fmt::format("{}{} {:.3f}", i == 0 ? "" : ", ", o.probabilities[i].first, o.probabilities[i].second);
  }
  if (o.probabilities.empty()) text += "none: it was never detected under this id";
  text += fmt::format("\n  seen           frames {} to {}, {} observations\n", o.first_frame, o.last_frame, o.observations);
  text += fmt::format("  size           {:.2f} x {:.2f} x {:.2f} m, {:.2f} m2 of surface\n", o.size_m.x(), o.size_m.y(),
                      o.size_m.z(), o.area_m2);
  text += fmt::format("  box            ({:.2f}, {:.2f}, {:.2f}) to ({:.2f}, {:.2f}, {:.2f}) m\n", o.min_m.x(), o.min_m.y(),
                      o.min_m.z(), o.max_m.x(), o.max_m.y(), o.max_m.z());
  text += votes_text(o) + views_text(o);
  if (!o.history.empty()) text += "  history\n";
  for (const std::string& line : o.history) text += fmt::format("    {}\n", line);
  return text;
}

}  // namespace panoptic
