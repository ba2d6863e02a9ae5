// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The predictor of the paper: semantic networks (one or several) and an instance network, joined by Eq. 1.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "panoptic/base/config.h"
#include "panoptic/data/labels.h"
#include "panoptic/data/segmentation.h"
#include "panoptic/predict/predictor.h"

namespace panoptic {

struct NetworkOptions {
  std::vector<std::string> semantic;      // model descriptions (TOML), their class probabilities are averaged; empty = no stuff
  std::string instance;                   // model description (TOML); empty = no things
  std::string engine = "auto";            // or "onnxruntime", "opencv"
  int threads = 0;                        // of inference; 0 = as many as everything else
  std::optional<double> score_threshold;  // instead of the one in the instance network's description
  // The likeliest of a network's own classes, then what it is in the label set (the paper). False: the probabilities of network
  // classes that are the same in the label set are added first.
  bool likeliest_first = false;
  float unknown_share = 0.7F;  // what counts of the probability of network classes that the label set lacks; 1 in the paper
  SegmentationOptions segmentation;
};

Fields fields(NetworkOptions& options);

// Loads the networks and runs each once on an empty image, so that a network that does not fit its description is found here
// and not in the first frame. At least one of the two must be given. Throws Error.
std::unique_ptr<Predictor> make_network_predictor(const NetworkOptions& options, LabelSet labels);

}  // namespace panoptic
