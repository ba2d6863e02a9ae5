// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The inference engines behind Network; nothing else includes this.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "panoptic/predict/network.h"

namespace panoptic {

// From the input in the network's own order of dimensions to its outputs, which have their names.
using Inference = std::function<std::vector<Tensor>(const Tensor&)>;

// Each loads a file of weights, and throws Error if it cannot. `threads` is positive.
Inference load_with_opencv(const std::filesystem::path& weights, const OnnxFile& file, int threads);
#ifdef PANOPTIC_ONNXRUNTIME
Inference load_with_onnxruntime(const std::filesystem::path& weights, int threads);
#endif

// Why OpenCV is not to be trusted with a network, because it would give other results than ONNX Runtime or die; else empty.
std::string why_not_opencv(const OnnxFile& file);

// Throws Error if an output has more numbers than any network for images gives: before memory is taken for them.
void require_size(std::uint64_t numbers, const std::string& output, const std::string& network);

// An engine's message for the text of an Error: the reason alone, without the places in the engine's own sources, and not pages
// of it.
std::string reason_in(std::string_view message);

}  // namespace panoptic
