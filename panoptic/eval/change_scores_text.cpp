// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <string_view>

#include "panoptic/eval/change_scores.h"

namespace panoptic {
namespace {

Json value_of(const std::optional<double>& score) { return score ? Json(*score) : Json(nullptr); }

std::string percent(const std::optional<double>& score) { return score ? fmt::format("{:.1f}", 100 * *score) : std::string("-"); }

Json json_of(const ChangeCounts& counts) {
  return {{"precision", value_of(counts.precision())},
          {"recall", value_of(counts.recall())},
          {"f1", value_of(counts.f1())},
          {"truths", counts.truths},
          {"found", counts.found},
          {"claims", counts.claims},
          {"repeated", counts.repeated},
          {"unjudged", counts.unjudged}};
}

std::string line(std::string_view name, const ChangeCounts& counts, const ChangeCounts& any_class) {
  return fmt::format("{:<8}{:>11}{:>8}{:>8}   {} of {} found, {} of {} claims right; of any class {} found, {} claims\n", name,
                     percent(counts.precision()), percent(counts.recall()), percent(counts.f1()), counts.found, counts.truths,
                     counts.found, counts.claims, any_class.found, any_class.claims);
}

}  // namespace

std::string to_table(const ChangeScores& s) {
  std::string text = fmt::format("\n{:<8}{:>11}{:>8}{:>8}\n", "changes", "precision", "recall", "F1");
  text += line("gone", s.gone, s.gone_any_class);
  text += line("new", s.fresh, s.fresh_any_class);
  text += line("moved", s.moved, s.moved_any_class);
  text += fmt::format("surface at the end: ghost share {}, completeness {}\n", percent(s.ghost_share), percent(s.completeness));
  if (s.moving) {
    text += fmt::format("moving pixels: precision {}, recall {}, F1 {} ({} frames, {} without a mask)\n",
                        percent(s.moving->precision()), percent(s.moving->recall()), percent(s.moving->f1()), s.moving->frames,
                        s.moving->without_mask);
  }
  return text;
}

Json to_json(const ChangeScores& s) {
  Json json = {{"gone", json_of(s.gone)}, {"new", json_of(s.fresh)}, {"moved", json_of(s.moved)}};
  json["any_class"] = {
      {"gone", json_of(s.gone_any_class)}, {"new", json_of(s.fresh_any_class)}, {"moved", json_of(s.moved_any_class)}};
  json["ghost_share"] = value_of(s.ghost_share);
  json["completeness"] = value_of(s.completeness);
  if (s.moving) {
    json["moving_pixels"] = {{"precision", value_of(s.moving->precision())},
                             {"recall", value_of(s.moving->recall())},
                             {"f1", value_of(s.moving->f1())},
                             {"true_positives", s.moving->both},
                             {"false_positives", s.moving->claimed_only},
                             {"false_negatives", s.moving->true_only},
                             {"frames", s.moving->frames},
                             {"frames_without_mask", s.moving->without_mask}};
  }
  return json;
}

}  // namespace panoptic
