// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The inference engines behind Network; nothing else includes this.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "panoptic/predict/network.h"

namespace panoptic {

using Inference = std::function<std::vector<Tensor>(const Tensor&)>;

// Each loads a file of weights, and throws Error if it cannot. `threads` is positive.
Inference load_with_opencv(const std::filesystem::path& weights, int threads);
#ifdef PANOPTIC_ONNXRUNTIME
Inference load_with_onnxruntime(const std::filesystem::path& weights, int threads);
#endif

// The beginning of an engine's message, which may be pages long, for the text of an Error.
std::string shortened(std::string_view message);

}  // namespace panoptic
