// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The counts of an evaluation as JSON, so that several processes can count the scenes of one benchmark.
#include <limits>
#include <utility>

#include "panoptic/error.h"
#include "panoptic/eval/evaluation_counts.h"

namespace panoptic {
namespace {

using Values = std::vector<JsonValue>;

constexpr std::int64_t kMostVertices = std::int64_t{1} << 52;  // a double holds every whole number below

Values elements(const JsonValue& array, std::size_t count) {
  Values values = array.elements();
  if (values.size() != count) array.wrong("an array of another length");
  return values;
}

std::uint64_t whole(const JsonValue& value, std::uint64_t below = kMostVertices) {
  return static_cast<std::uint64_t>(value.integer(0, static_cast<std::int64_t>(below) - 1));
}

double sum(const JsonValue& value) { return value.number(0, std::numeric_limits<double>::max()); }

Json to_json(const std::vector<InstanceAp::Overlap>& overlaps) {
  Json json = Json::array();
  for (const InstanceAp::Overlap& o : overlaps) json.push_back({o.other, o.vertices});
  return json;
}

std::vector<InstanceAp::Overlap> overlaps_in(const JsonValue& json, std::size_t others) {
  std::vector<InstanceAp::Overlap> overlaps;
  for (const JsonValue& pair : json.elements()) {
    const Values v = elements(pair, 2);
    overlaps.push_back({whole(v[0], others), whole(v[1])});
  }
  return overlaps;
}

Json to_json(const std::vector<InstanceAp::Scene>& scenes) {
  Json json = Json::array();
  for (const InstanceAp::Scene& scene : scenes) {
    Json truths = Json::array();
    for (const auto& t : scene.truths) truths.push_back({t.category, t.vertices, to_json(t.predictions)});
    Json predictions = Json::array();
    for (const auto& p : scene.predictions)
      predictions.push_back({p.category, p.vertices, p.on_void, p.confidence, to_json(p.truths)});
    json.push_back({{"truths", std::move(truths)}, {"predictions", std::move(predictions)}});
  }
  return json;
}

InstanceAp::Scene scene_in(const JsonValue& json) {
  InstanceAp::Scene scene;
  const Values truths = json.at("truths").elements();
  const Values predictions = json.at("predictions").elements();
  for (const JsonValue& truth : truths) {
    const Values v = elements(truth, 3);
    scene.truths.push_back({whole(v[0], kBenchmarkClassCount), whole(v[1]), overlaps_in(v[2], predictions.size())});
  }
  for (const JsonValue& prediction : predictions) {
    const Values v = elements(prediction, 5);
    scene.predictions.push_back(
        {whole(v[0], kBenchmarkClassCount), whole(v[1]), whole(v[2]), v[3].number(0, 1), overlaps_in(v[4], truths.size())});
  }
  return scene;
}

Json coverage_json(const Coverage& c) { return {c.vertices, c.annotated, c.reached, c.labelled}; }

void add_coverage(const JsonValue& saved, Coverage& coverage) {
  const Values v = elements(saved, 4);
  coverage.vertices += whole(v[0]);
  coverage.annotated += whole(v[1]);
  coverage.reached += whole(v[2]);
  coverage.labelled += whole(v[3]);
}

template <typename Counter>
Json saved_or_null(const std::optional<Counter>& counter) {
  return counter ? counter->saved() : Json(nullptr);
}

template <typename Counter>
void add_unless_null(const JsonValue& saved, std::optional<Counter>& counter) {
  if (!saved.is_null()) started(counter).add_saved(saved);
}

}  // namespace

Json SemanticIou::saved() const {
  Json rows = Json::array();
  for (const auto& row : confusion_) rows.push_back(row);
  return rows;
}

void SemanticIou::add_saved(const JsonValue& saved) {
  const Values rows = elements(saved, kBenchmarkClassCount);
  for (std::size_t c = 0; c < kBenchmarkClassCount; ++c) {
    const Values row = elements(rows[c], kColumns);
    for (std::size_t k = 0; k < kColumns; ++k) confusion_[c][k] += whole(row[k]);
  }
}

Json InstanceAp::saved() const { return {{"by_class", to_json(by_class_)}, {"agnostic", to_json(agnostic_)}}; }

void InstanceAp::add_saved(const JsonValue& saved) {
  const Values by_class = saved.at("by_class").elements();
  const Values agnostic = elements(saved.at("agnostic"), by_class.size());
  for (std::size_t i = 0; i < by_class.size(); ++i) {
    by_class_.push_back(scene_in(by_class[i]));
    agnostic_.push_back(scene_in(agnostic[i]));
  }
}

Json PanopticQuality::saved() const {
  Json json = Json::array();
  for (const PqCounts& c : counts_) json.push_back({c.tp, c.fp, c.fn, c.iou_sum});
  return json;
}

void PanopticQuality::add_saved(const JsonValue& saved) {
  const Values categories = elements(saved, counts_.size());
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    const Values v = elements(categories[i], 4);
    PqCounts& c = counts_[i];
    c.tp += whole(v[0]);
    c.fp += whole(v[1]);
    c.fn += whole(v[2]);
    c.iou_sum += sum(v[3]);
  }
}

Json SurfaceMetrics::saved() const {
  Json sides = Json::array();
  for (const Side* side : {&map_, &truth_})
    sides.push_back({side->points, side->measured, side->distance_sum_m, side->near[0], side->near[1]});
  return sides;
}

void SurfaceMetrics::add_saved(const JsonValue& saved) {
  const Values sides = elements(saved, 2);
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const Values v = elements(sides[i], 5);
    Side& side = i == 0 ? map_ : truth_;
    side.points += whole(v[0]);
    side.measured += whole(v[1]);
    side.distance_sum_m += sum(v[2]);
    side.near[0] += whole(v[3]);
    side.near[1] += whole(v[4]);
  }
}

std::string Evaluation::counts_text() const {
  const Counts& c = *counts_;
  Json variants = Json::array();
  for (const PqVariant& variant : c.variants) variants.push_back(variant.name);
  Json panoptic = Json::array();
  for (const PanopticQuality& quality : c.panoptic) panoptic.push_back(quality.saved());
  const Json json = {{"variants", variants},
                     {"scenes", c.scenes},
                     {"coverage", coverage_json(c.coverage)},
                     {"semantic", saved_or_null(c.semantic)},
                     {"instances", saved_or_null(c.instances)},
                     {"panoptic", panoptic},
                     {"surface", saved_or_null(c.surface)}};
  return json.dump();
}

void Evaluation::add_counts(const std::string& text, const std::string& origin) {
  const std::optional<Json> json = json_in(text);
  if (!json) throw Error(origin + ": no counts of an evaluation; make it again");
  const JsonValue saved(*json, origin);
  Counts& c = *counts_;
  const Values variants = elements(saved.at("variants"), c.variants.size());
  for (std::size_t i = 0; i < variants.size(); ++i) {
    if (variants[i].text() != c.variants[i].name) variants[i].wrong("counts of the variant " + c.variants[i].name);
  }
  for (const JsonValue& scene : saved.at("scenes").elements()) c.scenes.push_back(scene.text());
  add_coverage(saved.at("coverage"), c.coverage);
  add_unless_null(saved.at("semantic"), c.semantic);
  add_unless_null(saved.at("instances"), c.instances);
  const Values panoptic = saved.at("panoptic").elements();
  if (!panoptic.empty() && c.panoptic.empty()) c.panoptic.assign(c.variants.size(), PanopticQuality(kBenchmarkClassCount));
  if (!panoptic.empty() && panoptic.size() != c.panoptic.size()) saved.wrong("counts of each variant");
  for (std::size_t i = 0; i < panoptic.size(); ++i) c.panoptic[i].add_saved(panoptic[i]);
  add_unless_null(saved.at("surface"), c.surface);
}

}  // namespace panoptic
