// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/benchmark/experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <utility>

#include "panoptic/base/json_value.h"
#include "panoptic/error.h"
#include "panoptic/eval/benchmark_classes.h"
#include "panoptic/eval/instance_ap.h"
#include "panoptic/evaluation.h"
#include "panoptic/map.h"
#include "panoptic/mapper.h"
#include "panoptic/profile.h"
#include "panoptic/sim/ground_truth.h"
#include "panoptic/sim/prediction_noise.h"

namespace panoptic {
namespace {

constexpr std::size_t kMapsAtOnce = 4;  // a home's map takes some 200 MB at 2.4 cm
constexpr const char* kLabels = "scannet20";

Options options_of(const Setting& setting) {
  Options options = preset_options(setting.preset);
  for (const std::string& assignment : setting.set) set_option(options, assignment);
  return options;
}

// One setting's map of one home while it grows.
struct Mapping {
  const Setting& setting;
  std::unique_ptr<Mapper> mapper;  // one of the two
  std::unique_ptr<SubstituteMapper> substitute;

  Mapping(const Setting& of, const LabelSet& labels) : setting(of) {
    if (of.substitutes) {
      substitute = std::make_unique<SubstituteMapper>(options_of(of), labels, *of.substitutes);
    } else {
      mapper = std::make_unique<Mapper>(options_of(of), labels);
    }
  }

  void add(const SimulatedFrame& frame, const Segmentation& segmentation) const {
    const Outcome outcome =
        mapper ? mapper->add(frame.frame, segmentation) : substitute->add(frame.frame, segmentation, frame.rendering.instance);
    if (!outcome.used) throw Error(fmt::format("simulated frame {} was refused: {}", frame.frame.index, outcome.reason));
  }
};

PartCounts finished(const Mapping& mapping, const ScanTruth& truth) {
  PartCounts counts;
  if (mapping.mapper) mapping.mapper->finish();
  const PanopticMap& mapped = mapping.mapper ? mapping.mapper->map() : mapping.substitute->map();
  const LabelledMap map = labelled_map(mapped, mapping.mapper ? mapping.mapper->mesh() : mapping.substitute->mesh());
  counts.objects = map.confidence.size();
  counts.map_mb = static_cast<double>(mapped.voxels.memory_bytes()) / 1e6;
  counts.evaluation.add(map, truth);
  if (!mapping.mapper) return counts;
  const auto& stages = mapping.mapper->profile().stages();
  if (const auto stage = stages.find("fusion"); stage != stages.end()) counts.fusion_p50_ms = stage->second.percentile_ms(0.5);
  if (const auto stage = stages.find("regularize"); stage != stages.end()) counts.regularize_ms = stage->second.mean_ms();
  return counts;
}

// Every frame of the home into every mapping; a segmentation is made once per preset. False if `tick` says so.
bool map_home(const Simulation& simulation, const std::vector<Mapping>& mappings, const LabelSet& labels,
              const std::function<bool(const SimulatedFrame&)>& tick) {
  std::map<std::string, PredictionNoise> presets;
  for (const Mapping& mapping : mappings)
    presets[mapping.setting.predictions] = prediction_noise_preset(mapping.setting.predictions);
  for (std::size_t position = 0; position < simulation.size(); ++position) {
    const SimulatedFrame frame = simulation.simulate(position);
    std::map<std::string, Segmentation> segmentations;
    for (const auto& [name, noise] : presets) {
      segmentations[name] = predict_with_noise(noise, simulation.options().seed, frame, labels);
    }
    for (const Mapping& mapping : mappings) mapping.add(frame, segmentations[mapping.setting.predictions]);
    if (!tick(frame)) return false;
  }
  return true;
}

std::size_t count_things(const ScanTruth& truth) {
  std::map<std::uint16_t, std::size_t> vertices;
  for (std::size_t i = 0; i < truth.instance.size(); ++i) {
    if (truth.instance[i] != 0 && is_benchmark_thing(truth.class_id[i])) ++vertices[truth.instance[i]];
  }
  return static_cast<std::size_t>(std::ranges::count_if(vertices, [](const auto& v) { return v.second >= kMinRegionVertices; }));
}

}  // namespace

std::vector<ExperimentPart> parts_of(const Experiment& experiment) {
  std::map<std::string, std::vector<std::size_t>> by_noise;
  for (std::size_t i = 0; i < experiment.settings.size(); ++i) by_noise[experiment.settings[i].noise].push_back(i);
  std::vector<ExperimentPart> parts;
  for (std::size_t home = 0; home < experiment.homes.size(); ++home) {
    const std::size_t first = parts.size();
    for (const auto& [noise, indices] : by_noise) {
      for (std::size_t i = 0; i < indices.size(); ++i) {
        if (i % kMapsAtOnce == 0) parts.push_back({home, {}, parts.size() == first});
        parts.back().settings.push_back(indices[i]);
      }
    }
  }
  return parts;
}

void require_sound(const Experiment& experiment) {
  for (const Setting& setting : experiment.settings) {
    options_of(setting);
    sensor_noise_preset(setting.noise);
    prediction_noise_preset(setting.predictions);
  }
}

std::optional<PartResult> run_part(const Experiment& experiment, const ExperimentPart& part,
                                   const std::function<bool(std::size_t, std::size_t)>& progress) {
  require_sound(experiment);
  SimulationOptions options = experiment.homes[part.home];
  options.noise = experiment.settings[part.settings.front()].noise;
  const Simulation simulation(options);
  const LabelSet labels = load_label_set(kLabels);
  std::vector<Mapping> mappings;
  for (const std::size_t i : part.settings) mappings.emplace_back(experiment.settings[i], labels);
  TruthBuilder builder;
  std::size_t done = 0;
  const bool whole = map_home(simulation, mappings, labels, [&](const SimulatedFrame& frame) {
    builder.add(frame);
    return progress(++done, simulation.size());
  });
  if (!whole) return std::nullopt;
  const ScanTruth truth = builder.finish(simulation);
  PartResult result{{}, count_things(truth)};
  for (const Mapping& mapping : mappings) result.counts.push_back(finished(mapping, truth));
  return result;
}

std::vector<SettingResult> outcomes_of(const Experiment& experiment, const std::vector<PartResult>& results) {
  const std::vector<ExperimentPart> parts = parts_of(experiment);
  PANOPTIC_ASSERT(parts.size() == results.size());
  std::vector<PartCounts> totals(experiment.settings.size());
  std::size_t true_things = 0;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    if (parts[p].is_first_of_home) true_things += results[p].true_things;
    for (std::size_t i = 0; i < parts[p].settings.size(); ++i) {
      const PartCounts& counts = results[p].counts[i];
      PartCounts& total = totals[parts[p].settings[i]];
      total.evaluation.add_counts(counts.evaluation.counts_text(), "benchmark");
      total.fusion_p50_ms += counts.fusion_p50_ms;
      total.regularize_ms += counts.regularize_ms;
      total.map_mb = std::max(total.map_mb, counts.map_mb);
      total.objects += counts.objects;
    }
  }
  const double homes = static_cast<double>(std::max<std::size_t>(experiment.homes.size(), 1));
  std::vector<SettingResult> outcomes;
  for (std::size_t i = 0; i < totals.size(); ++i) {
    const PartCounts& t = totals[i];
    outcomes.push_back({experiment.settings[i], t.evaluation.scores(), t.fusion_p50_ms / homes, t.regularize_ms / homes, t.map_mb,
                        t.objects, true_things});
  }
  return outcomes;
}

Json to_json(const PartResult& result) {
  Json counts = Json::array();
  for (const PartCounts& c : result.counts) {
    counts.push_back({{"counts", c.evaluation.counts_text()},
                      {"fusion_p50_ms", c.fusion_p50_ms},
                      {"regularize_ms", c.regularize_ms},
                      {"map_mb", c.map_mb},
                      {"objects", c.objects}});
  }
  return {{"true_things", result.true_things}, {"settings", std::move(counts)}};
}

PartResult part_result_in(const Json& json, const std::string& file) {
  constexpr double kMost = 1e12;
  constexpr std::int64_t kMostThings = 1'000'000'000;
  const JsonValue saved(json, file);
  PartResult result{{}, static_cast<std::size_t>(saved.at("true_things").integer(0, kMostThings))};
  for (const JsonValue& setting : saved.at("settings").elements()) {
    PartCounts& counts = result.counts.emplace_back();
    counts.evaluation.add_counts(setting.at("counts").text(), file);
    counts.fusion_p50_ms = setting.at("fusion_p50_ms").number(0, kMost);
    counts.regularize_ms = setting.at("regularize_ms").number(0, kMost);
    counts.map_mb = setting.at("map_mb").number(0, kMost);
    counts.objects = static_cast<std::size_t>(setting.at("objects").integer(0, kMostThings));
  }
  return result;
}

}  // namespace panoptic
