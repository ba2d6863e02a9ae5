// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/eval/scores_text.h"

#include <fmt/format.h>

#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "panoptic/eval/panoptic_quality.h"

namespace panoptic {
namespace {

using Score = std::optional<double>;

// A column of the table: a score per class and its mean.
struct Column {
  std::string name;
  std::vector<Score> classes;  // as in benchmark_classes()
  Score all;
  Score things;
  Score stuff;
};

Json value_of(const Score& score) { return score ? Json(*score) : Json(nullptr); }

std::vector<Column> instance_columns(const InstanceScores& instance) {
  std::vector<Column> columns;
  for (const auto& [name, score] : {std::pair("ap", &ApScores::ap), {"ap50", &ApScores::ap50}, {"ap25", &ApScores::ap25}}) {
    Column column{name, {}, {}, instance.mean.*score, {}};
    for (const ApScores& c : instance.classes) column.classes.push_back(c.*score);
    columns.push_back(std::move(column));
  }
  return columns;
}

std::vector<Column> panoptic_columns(const PanopticScores& panoptic) {
  std::vector<Column> columns;
  for (const auto& [name, score] : {std::pair("pq", &PqScores::pq), {"sq", &PqScores::sq}, {"rq", &PqScores::rq}}) {
    Column column{name, {}, panoptic.all.*score, panoptic.things.*score, panoptic.stuff.*score};
    for (const PqCounts& c : panoptic.counts) column.classes.push_back(pq_scores(c).*score);
    columns.push_back(std::move(column));
  }
  return columns;
}

// The columns of the scores, the benchmark's own ones first.
std::vector<Column> columns_of(const Scores& scores) {
  std::vector<Column> columns;
  if (scores.instance) columns = instance_columns(*scores.instance);
  if (scores.semantic) {
    Column column{"iou", {}, scores.semantic->miou, {}, {}};
    for (const ClassIou& c : scores.semantic->classes) column.classes.push_back(c.iou());
    columns.push_back(std::move(column));
  }
  if (!scores.panoptic.empty()) {
    for (Column& column : panoptic_columns(scores.panoptic.front())) columns.push_back(std::move(column));
  }
  return columns;
}

// Instances alone: wall and floor are not in that benchmark.
bool is_listed(std::size_t c, const Scores& scores) {
  return scores.semantic || !scores.panoptic.empty() || benchmark_classes()[c].is_thing;
}

Json to_json(const PqVariant& v) {
  return {{"min_true_thing_vertices", v.min_true_thing},
          {"min_predicted_thing_vertices", v.min_predicted_thing},
          {"one_segment_per_stuff_class", v.merge_stuff},
          {"averages", v.average_true_only ? "classes with ground truth" : "classes with ground truth or predictions"},
          {"void", "truth outside the 20 classes"}};
}

void put_panoptic(const PanopticScores& panoptic, Json& json) {
  for (const Column& column : panoptic_columns(panoptic)) {
    json[column.name] = {{"all", value_of(column.all)}, {"things", value_of(column.things)}, {"stuff", value_of(column.stuff)}};
  }
  json["variant"] = panoptic.variant.name;
  json["rules"] = to_json(panoptic.variant);
}

Json to_json(const SurfaceScores& surface) {
  Json at = Json::array();
  for (const ThresholdScores& t : surface.at) {
    at.push_back({{"threshold_m", t.threshold_m},
                  {"precision", value_of(t.precision)},
                  {"recall", value_of(t.recall)},
                  {"f_score", value_of(t.f_score)}});
  }
  return {{"accuracy_m", value_of(surface.accuracy_m)}, {"completion_m", value_of(surface.completion_m)}, {"at", std::move(at)}};
}

Json class_json(std::size_t c, const Scores& scores, const std::vector<Column>& columns) {
  Json json = {{"id", number(benchmark_classes()[c].id)}, {"is_thing", benchmark_classes()[c].is_thing}};
  for (const Column& column : columns) json[column.name] = value_of(column.classes[c]);
  if (scores.semantic) {
    const ClassIou& n = scores.semantic->classes[c];
    json["iou_counts"] = {{"tp", n.tp}, {"fp", n.fp}, {"fn", n.fn}};
  }
  if (!scores.panoptic.empty()) {
    const PqCounts& n = scores.panoptic.front().counts[c];
    json["pq_counts"] = {{"tp", n.tp}, {"fp", n.fp}, {"fn", n.fn}, {"iou_sum", n.iou_sum}};
  }
  return json;
}

std::string percent(const Score& score) { return score ? fmt::format("{:.1f}", 100 * *score) : std::string("-"); }

std::string table_row(const std::string& name, const std::vector<Column>& columns,
                      const std::function<Score(const Column&)>& score) {
  std::string line = fmt::format("{:<16}", name);
  for (const Column& column : columns) line += fmt::format("{:>8}", percent(score(column)));
  return line + "\n";
}

std::string variant_lines(const Scores& scores) {
  std::string text;
  for (const PanopticScores& p : scores.panoptic) {
    const PqVariant& v = p.variant;
    text += fmt::format(
        "{:<13} PQ {:>5}  SQ {:>5}  RQ {:>5}  things {:>5}  stuff {:>5}   (true things >= {}, predicted >= {} vertices; {}; "
        "{})\n",
        v.name, percent(p.all.pq), percent(p.all.sq), percent(p.all.rq), percent(p.things.pq), percent(p.stuff.pq),
        v.min_true_thing, v.min_predicted_thing, v.merge_stuff ? "stuff merged" : "stuff as it is",
        v.average_true_only ? "true classes" : "true or predicted classes");
  }
  return text;
}

std::string surface_lines(const SurfaceScores& s) {
  const auto centimetres = [](const Score& m) { return m ? fmt::format("{:.2f} cm", 100 * *m) : std::string("-"); };
  std::string text =
      fmt::format("surface       accuracy {}, completion {}\n", centimetres(s.accuracy_m), centimetres(s.completion_m));
  for (const ThresholdScores& t : s.at) {
    text += fmt::format("  at {:>4.1f} cm  precision {}, recall {}, F-score {}\n", 100 * t.threshold_m, percent(t.precision),
                        percent(t.recall), percent(t.f_score));
  }
  return text;
}

}  // namespace

Json to_json(const Scores& scores) {
  Json json = {{"scenes", scores.scenes},
               {"coverage", value_of(scores.coverage.coverage())},
               {"vertices",
                {{"all", scores.coverage.vertices},
                 {"annotated", scores.coverage.annotated},
                 {"reached", scores.coverage.reached},
                 {"labelled", scores.coverage.labelled}}}};
  if (scores.semantic) json["miou"] = value_of(scores.semantic->miou);
  if (scores.instance) {
    const auto put = [](const ApScores& s, Json& to) {
      to["ap"] = value_of(s.ap);
      to["ap50"] = value_of(s.ap50);
      to["ap25"] = value_of(s.ap25);
    };
    put(scores.instance->mean, json);
    put(scores.instance->class_agnostic, json["class_agnostic"]);
    json["class_agnostic"]["truth"] = "instances of the 18 thing classes; wall and floor are not kept";
  }
  if (!scores.panoptic.empty()) put_panoptic(scores.panoptic.front(), json);
  for (const PanopticScores& p : scores.panoptic) put_panoptic(p, json["pq_variants"][p.variant.name]);
  if (scores.surface) json["surface"] = to_json(*scores.surface);
  const std::vector<Column> columns = columns_of(scores);
  for (std::size_t c = 0; c < kBenchmarkClassCount; ++c) {
    if (is_listed(c, scores)) json["per_class"][std::string(benchmark_classes()[c].name)] = class_json(c, scores, columns);
  }
  return json;
}

std::string to_json_text(const Scores& scores) { return to_json(scores).dump(); }

std::string to_csv(const Scores& scores) {
  const std::vector<Column> columns = columns_of(scores);
  std::string text = "class,class id";
  for (const Column& column : columns) text += "," + column.name;
  text += "\n";
  for (std::size_t c = 0; c < kBenchmarkClassCount; ++c) {
    if (!is_listed(c, scores)) continue;
    text += fmt::format("{},{}", benchmark_classes()[c].name, number(benchmark_classes()[c].id));
    for (const Column& column : columns) text += column.classes[c] ? fmt::format(",{}", *column.classes[c]) : ",nan";
    text += "\n";
  }
  return text;
}

std::string to_table(const Scores& scores) {
  const std::vector<Column> columns = columns_of(scores);
  std::string text = fmt::format("{:<16}", "class");
  for (const Column& column : columns) text += fmt::format("{:>8}", column.name);
  text += "\n";
  for (std::size_t c = 0; c < kBenchmarkClassCount; ++c) {
    if (!is_listed(c, scores)) continue;
    text += table_row(std::string(benchmark_classes()[c].name), columns, [&](const Column& column) { return column.classes[c]; });
  }
  text += table_row("all", columns, [](const Column& column) { return column.all; });
  text += table_row("things", columns, [](const Column& column) { return column.things; });
  if (!scores.panoptic.empty()) text += table_row("stuff", columns, [](const Column& column) { return column.stuff; });
  text += "\n" + variant_lines(scores);
  if (scores.instance) {
    const ApScores& a = scores.instance->class_agnostic;
    text += fmt::format("no classes    AP {}, AP50 {}, AP25 {} (true instances of the 18 thing classes)\n", percent(a.ap),
                        percent(a.ap50), percent(a.ap25));
  }
  if (scores.surface) text += surface_lines(*scores.surface);
  const Coverage& n = scores.coverage;
  text += fmt::format("coverage      {} % of {} annotated vertices have a label ({} have a surface near); {} scenes\n",
                      percent(n.coverage()), n.annotated, n.reached, scores.scenes.size());
  return text;
}

}  // namespace panoptic
