// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/benchmark/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <limits>
#include <optional>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/benchmark/chart.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr double kPercent = 100;

const SettingResult& outcome_of(std::span<const SettingResult> outcomes, const std::string& name) {
  const auto found =
      std::ranges::find(outcomes, name, [](const SettingResult& o) -> const std::string& { return o.setting.name; });
  PANOPTIC_ASSERT(found != outcomes.end());
  return *found;
}

std::string percent(const std::optional<double>& fraction) {
  return fraction ? fmt::format("{:.1f}", *fraction * kPercent) : "–";
}

double value(const std::optional<double>& fraction) {
  return fraction ? *fraction * kPercent : std::numeric_limits<double>::quiet_NaN();
}

std::optional<double> miou(const SettingResult& o) { return o.scores.semantic ? o.scores.semantic->miou : std::nullopt; }
std::optional<double> ap50(const SettingResult& o) { return o.scores.instance ? o.scores.instance->mean.ap50 : std::nullopt; }
std::optional<double> f_score(const SettingResult& o) {
  return o.scores.surface ? o.scores.surface->at.front().f_score : std::nullopt;
}

std::string row(const SettingResult& o) {
  const PanopticScores& pq = o.scores.panoptic.front();
  return fmt::format("| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {:.1f} | {:.0f} | {:.0f} | {} |\n", o.setting.name,
                     percent(pq.all.pq), percent(pq.things.pq), percent(pq.stuff.pq), percent(pq.all.sq), percent(pq.all.rq),
                     percent(miou(o)), percent(ap50(o)), percent(f_score(o)), percent(o.scores.coverage.coverage()),
                     o.fusion_p50_ms, o.regularize_ms, o.map_mb, o.objects);
}

std::string file_name(const std::string& title) {
  std::string name;
  for (const char c : title) name += std::isalnum(static_cast<unsigned char>(c)) != 0 ? static_cast<char>(std::tolower(c)) : '_';
  return name + ".png";
}

Chart chart_of(const Group& group, std::span<const SettingResult> outcomes) {
  Chart chart{
      .kind = group.chart, .title = group.title, .x_axis = "", .y_axis = "percent", .categories = group.settings, .series = {}};
  chart.series = {{"PQ", {}}, {"PQ things", {}}, {"PQ stuff", {}}, {"mIoU", {}}};
  // Times as shares of the longest: in milliseconds they would press the scores flat.
  double longest_ms = 0;
  for (const std::string& name : group.settings) longest_ms = std::max(longest_ms, outcome_of(outcomes, name).regularize_ms);
  if (group.measure == Measure::kPqAndTime) {
    const std::string time = fmt::format("a run of the regularizer (100 = {:.2f} s)", longest_ms / 1000);
    chart.series = {{"PQ", {}}, {"mIoU", {}}, {time, {}}};
  }
  for (const std::string& name : group.settings) {
    const SettingResult& o = outcome_of(outcomes, name);
    const PanopticScores& pq = o.scores.panoptic.front();
    std::vector<double> values{value(pq.all.pq), value(pq.things.pq), value(pq.stuff.pq), value(miou(o))};
    if (group.measure == Measure::kPqAndTime) {
      values = {value(pq.all.pq), value(miou(o)), longest_ms > 0 ? 100 * o.regularize_ms / longest_ms : 0};
    }
    for (std::size_t i = 0; i < values.size(); ++i) chart.series[i].values.push_back(values[i]);
  }
  return chart;
}

std::string homes_text(const Study& study) {
  std::string text;
  for (const SimulationOptions& home : study.experiment.homes) {
    text += fmt::format("{}sim:{},rooms={},frames={}", text.empty() ? "" : ", ", home.seed, home.rooms, home.frames);
  }
  return text;
}

std::string setting_text(const Setting& s) {
  std::string text = fmt::format("- **{}**: noise `{}`, masks `{}`", s.name, s.noise, s.predictions);
  for (const std::string& option : s.set) text += fmt::format(", `--set {}`", option);
  if (s.substitutes && s.substitutes->tracking) text += ", true tracking";
  if (s.substitutes && s.substitutes->storage) text += ", all votes stored";
  return text + "\n";
}

Json or_null(const std::optional<double>& number) { return number ? Json(*number) : Json(nullptr); }

Json three(const PanopticScores& scores, std::optional<double> PqScores::*member) {
  return {
      {"all", or_null(scores.all.*member)}, {"things", or_null(scores.things.*member)}, {"stuff", or_null(scores.stuff.*member)}};
}

}  // namespace

std::string markdown(const Study& study, std::span<const SettingResult> outcomes) {
  std::string text = "# Benchmark on simulated homes\n\n";
  const std::size_t things = outcomes.empty() ? 0 : outcomes.front().true_things;
  text += fmt::format(
      "Homes: {}; {} true things of 100 vertices or more. PQ variant `{}`. Scores in percent over all homes; fusion and "
      "regularizer (one run) in ms, map in MB.\n",
      homes_text(study), things, outcomes.empty() ? "" : outcomes.front().scores.panoptic.front().variant.name);
  for (const Group& group : study.groups) {
    text += fmt::format("\n## {}\n\n{}\n\n", group.title, group.question);
    text += "| setting | PQ | things | stuff | SQ | RQ | mIoU | AP50 | F 5 cm | coverage | fusion | CRF | map | objects |\n";
    text += "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
    for (const std::string& name : group.settings) text += row(outcome_of(outcomes, name));
    text += fmt::format("\n![{}]({})\n", group.title, file_name(group.title));
  }
  text += "\n## Settings\n\n";
  for (const SettingResult& o : outcomes) text += setting_text(o.setting);
  return text;
}

Json to_json(const Study& study, std::span<const SettingResult> outcomes) {
  Json settings = Json::object();
  for (const SettingResult& o : outcomes) {
    const PanopticScores& pq = o.scores.panoptic.front();
    settings[o.setting.name] = {{"noise", o.setting.noise},
                                {"predictions", o.setting.predictions},
                                {"set", o.setting.set},
                                {"pq", three(pq, &PqScores::pq)},
                                {"sq", three(pq, &PqScores::sq)},
                                {"rq", three(pq, &PqScores::rq)},
                                {"miou", or_null(miou(o))},
                                {"ap", or_null(o.scores.instance ? o.scores.instance->mean.ap : std::nullopt)},
                                {"ap50", or_null(ap50(o))},
                                {"ap25", or_null(o.scores.instance ? o.scores.instance->mean.ap25 : std::nullopt)},
                                {"f_score", or_null(f_score(o))},
                                {"coverage", or_null(o.scores.coverage.coverage())},
                                {"fusion_p50_ms", o.fusion_p50_ms},
                                {"regularize_ms", o.regularize_ms},
                                {"map_mb", o.map_mb},
                                {"objects", o.objects}};
  }
  Json groups = Json::array();
  for (const Group& g : study.groups) groups.push_back({{"title", g.title}, {"settings", g.settings}});
  return {{"homes", homes_text(study)}, {"settings", std::move(settings)}, {"groups", std::move(groups)}};
}

void write_report(const std::filesystem::path& folder, const Study& study, std::span<const SettingResult> outcomes) {
  for (const Group& group : study.groups) write_png(folder / file_name(group.title), draw(chart_of(group, outcomes)));
  write_file(folder / "report.md", markdown(study, outcomes));
  write_json_file(folder / "report.json", to_json(study, outcomes));
}

std::vector<std::string> below(std::span<const Floor> floors, std::span<const SettingResult> outcomes) {
  std::vector<std::string> result;
  const auto check = [&](const Floor& floor, const char* what, std::optional<double> score, double least) {
    if (score.value_or(0) < least) {
      result.push_back(fmt::format("{}: {} {} is below {:.1f}", floor.setting, what, percent(score), least * kPercent));
    }
  };
  for (const Floor& floor : floors) {
    const SettingResult& o = outcome_of(outcomes, floor.setting);
    check(floor, "PQ", o.scores.panoptic.front().all.pq, floor.pq);
    check(floor, "mIoU", miou(o), floor.miou);
  }
  return result;
}

}  // namespace panoptic
