// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predictor.h"

#include <optional>

#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr const char* kDefaultLabels = "indoor";

}  // namespace

std::unique_ptr<Predictor> make_predictor(const Options& options) {
  const bool networks = !options.networks.semantic.empty() || !options.networks.instance.empty();
  if (!options.predictions.empty() && networks) {
    throw Error("both a prediction folder and networks are given; choose one");
  }
  const auto labels = options.labels.empty() ? std::nullopt : std::optional(load_label_set(options.labels));
  if (!options.predictions.empty()) {
    return make_file_predictor(options.predictions, labels, options.networks.segmentation.keep_whole_classes);
  }
  if (networks) return make_network_predictor(options.networks, labels.value_or(load_label_set(kDefaultLabels)));
  return nullptr;
}

LabelSet labels_of(const Options& options, const Predictor* predictor) {
  if (predictor != nullptr) return predictor->labels();
  return load_label_set(options.labels.empty() ? kDefaultLabels : options.labels);
}

}  // namespace panoptic
