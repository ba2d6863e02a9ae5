// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predictor.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "panoptic/error.h"
#include "panoptic/io/recording_list.h"
#include "panoptic/predict/join_predictors.h"

namespace panoptic {
namespace {

constexpr const char* kDefaultLabels = "indoor";

bool names_networks(const Options& options) { return !options.networks.semantic.empty() || !options.networks.instance.empty(); }

std::optional<LabelSet> asked_labels(const Options& options) {
  return options.labels.empty() ? std::nullopt : std::optional(load_label_set(options.labels));
}

bool names_predictions(const RecordingList& list) {
  return std::any_of(list.parts().begin(), list.parts().end(), [](const auto& part) { return !part.listed.predictions.empty(); });
}

std::unique_ptr<Predictor> listed_predictions(const RecordingList& list, const Options& options) {
  const std::optional<LabelSet> labels = asked_labels(options);
  std::vector<NumberedPredictor> predictors;
  for (const RecordingList::Part& part : list.parts()) {
    const std::string& path = part.listed.predictions;
    predictors.push_back({part.first_number, path, nullptr});
    if (path.empty()) continue;
    predictors.back().predictor = make_file_predictor(path, labels, options.networks.segmentation.keep_whole_classes);
  }
  return join_predictors(std::move(predictors));
}

}  // namespace

std::unique_ptr<Predictor> make_predictor(const Options& options) {
  if (!options.predictions.empty() && names_networks(options)) {
    throw Error("both a prediction folder and networks are given; choose one");
  }
  const std::optional<LabelSet> labels = asked_labels(options);
  if (!options.predictions.empty()) {
    return make_file_predictor(options.predictions, labels, options.networks.segmentation.keep_whole_classes);
  }
  if (names_networks(options)) return make_network_predictor(options.networks, labels.value_or(load_label_set(kDefaultLabels)));
  return nullptr;
}

std::unique_ptr<Predictor> make_predictor(const Options& options, const Dataset& dataset) {
  const RecordingList* list = as_recording_list(dataset);
  const bool is_asked = !options.predictions.empty() || names_networks(options);
  if (list == nullptr || is_asked || !names_predictions(*list)) return make_predictor(options);
  return listed_predictions(*list, options);
}

LabelSet labels_of(const Options& options, const Predictor* predictor) {
  if (predictor != nullptr) return predictor->labels();
  return load_label_set(options.labels.empty() ? kDefaultLabels : options.labels);
}

}  // namespace panoptic
