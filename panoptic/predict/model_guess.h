// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A description for a network that has none: from what its file says and what its outputs look like.
#pragma once

#include <filesystem>
#include <string>

#include "panoptic/predict/decoders.h"
#include "panoptic/predict/model.h"

namespace panoptic {

// `name`, `weights`, the size of the input, and classes: those that the file names (Ultralytics), or else a list of a well-known
// data set with which the outputs can be read, or else numbers. Throws Error if the outputs are not understood with any.
Model guess_model(const std::filesystem::path& onnx, Engine engine);

// A description as load_model reads it, with what there is to check as comments.
std::string to_toml(const Model& model, const Reading& reading);

}  // namespace panoptic
