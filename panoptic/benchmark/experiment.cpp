// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/benchmark/experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <utility>

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

struct Totals {
  Evaluation evaluation;
  double fusion_p50_ms = 0;
  double regularize_ms = 0;
  double map_mb = 0;
  std::size_t objects = 0;
};

void finish(const Mapping& mapping, const ScanTruth& truth, Totals& totals) {
  if (mapping.mapper) mapping.mapper->finish();
  const PanopticMap& mapped = mapping.mapper ? mapping.mapper->map() : mapping.substitute->map();
  const LabelledMap map = labelled_map(mapped, mapping.mapper ? mapping.mapper->mesh() : mapping.substitute->mesh());
  totals.objects += map.confidence.size();
  totals.map_mb = std::max(totals.map_mb, static_cast<double>(mapped.voxels.memory_bytes()) / 1e6);
  totals.evaluation.add(map, truth);
  if (!mapping.mapper) return;
  const auto& stages = mapping.mapper->profile().stages();
  if (const auto stage = stages.find("fusion"); stage != stages.end()) totals.fusion_p50_ms += stage->second.percentile_ms(0.5);
  if (const auto stage = stages.find("regularize"); stage != stages.end()) totals.regularize_ms += stage->second.mean_ms();
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

// Settings of equal noise, a few at a time: indices into the experiment's settings.
std::vector<std::vector<std::size_t>> batches(const std::vector<Setting>& settings) {
  std::map<std::string, std::vector<std::size_t>> by_noise;
  for (std::size_t i = 0; i < settings.size(); ++i) by_noise[settings[i].noise].push_back(i);
  std::vector<std::vector<std::size_t>> result;
  for (const auto& [noise, indices] : by_noise) {
    for (std::size_t i = 0; i < indices.size(); ++i) {
      if (i % kMapsAtOnce == 0) result.emplace_back();
      result.back().push_back(indices[i]);
    }
  }
  return result;
}

std::size_t count_things(const ScanTruth& truth) {
  std::map<std::uint16_t, std::size_t> vertices;
  for (std::size_t i = 0; i < truth.instance.size(); ++i) {
    if (truth.instance[i] != 0 && is_benchmark_thing(truth.class_id[i])) ++vertices[truth.instance[i]];
  }
  return static_cast<std::size_t>(std::ranges::count_if(vertices, [](const auto& v) { return v.second >= kMinRegionVertices; }));
}

// The experiment while it runs.
struct Course {
  const Experiment& experiment;
  const std::function<bool(std::size_t, std::size_t)>& progress;
  LabelSet labels = load_label_set(kLabels);
  std::vector<Totals> totals{experiment.settings.size()};
  std::size_t true_things = 0;
  std::size_t frames_done = 0;
  std::size_t passes_left = 0;
};

// Maps one home under the settings of one batch; the first pass over a home makes its truth on the way. False if interrupted.
bool make_pass(const SimulationOptions& home, const std::vector<std::size_t>& batch, std::optional<ScanTruth>& truth,
               Course& course) {
  SimulationOptions options = home;
  options.noise = course.experiment.settings[batch.front()].noise;
  const Simulation simulation(options);
  std::vector<Mapping> mappings;
  for (const std::size_t i : batch) mappings.emplace_back(course.experiment.settings[i], course.labels);
  TruthBuilder builder;
  --course.passes_left;
  std::size_t left = simulation.size();
  const bool whole = map_home(simulation, mappings, course.labels, [&](const SimulatedFrame& frame) {
    if (!truth) builder.add(frame);
    ++course.frames_done;
    return course.progress(course.frames_done, course.frames_done + --left + course.passes_left * simulation.size());
  });
  if (!whole) return false;
  if (!truth) {
    truth = builder.finish(simulation);
    course.true_things += count_things(*truth);
  }
  for (std::size_t i = 0; i < batch.size(); ++i) finish(mappings[i], *truth, course.totals[batch[i]]);
  return true;
}

}  // namespace

std::vector<SettingResult> run(const Experiment& experiment, const std::function<bool(std::size_t, std::size_t)>& progress) {
  for (const Setting& setting : experiment.settings) {  // mistakes show before hours are spent
    options_of(setting);
    sensor_noise_preset(setting.noise);
    prediction_noise_preset(setting.predictions);
  }
  const auto passes = batches(experiment.settings);
  Course course{experiment, progress};
  course.passes_left = passes.size() * experiment.homes.size();
  for (const SimulationOptions& home : experiment.homes) {
    std::optional<ScanTruth> truth;
    for (const auto& batch : passes) {
      if (!make_pass(home, batch, truth, course)) return {};
    }
  }
  const double homes = static_cast<double>(std::max<std::size_t>(experiment.homes.size(), 1));
  std::vector<SettingResult> outcomes;
  for (std::size_t i = 0; i < course.totals.size(); ++i) {
    const Totals& t = course.totals[i];
    outcomes.push_back({experiment.settings[i], t.evaluation.scores(), t.fusion_p50_ms / homes, t.regularize_ms / homes, t.map_mb,
                        t.objects, course.true_things});
  }
  return outcomes;
}

}  // namespace panoptic
