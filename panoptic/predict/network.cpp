// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predict/network.h"

#include <fmt/format.h>

#include <algorithm>

#include "panoptic/error.h"
#include "panoptic/parallel.h"
#include "panoptic/predict/inference.h"

namespace panoptic {
namespace {

void require_file(const std::filesystem::path& weights) {
  std::error_code error;
  if (std::filesystem::is_regular_file(weights, error)) return;
  throw Error(fmt::format("there is no network file {}: check the path in the model description", weights.string()));
}

Inference load(const std::filesystem::path& weights, Engine engine, int threads) {
  require_file(weights);
#ifdef PANOPTIC_ONNXRUNTIME
  if (engine == Engine::kOnnxRuntime) return load_with_onnxruntime(weights, threads);
#endif
  if (engine == Engine::kOpenCv) return load_with_opencv(weights, threads);
  throw Error(fmt::format("the engine {} is not built in; use opencv", name_of(engine)));
}

}  // namespace

std::vector<Engine> built_in_engines() {
#ifdef PANOPTIC_ONNXRUNTIME
  return {Engine::kOnnxRuntime, Engine::kOpenCv};
#else
  return {Engine::kOpenCv};
#endif
}

std::string_view name_of(Engine engine) { return engine == Engine::kOnnxRuntime ? "onnxruntime" : "opencv"; }

Engine engine_from(std::string_view name) {
  const std::vector<Engine> engines = built_in_engines();
  if (name == "auto") return engines.front();
  const auto found = std::find_if(engines.begin(), engines.end(), [&](Engine engine) { return name_of(engine) == name; });
  if (found != engines.end()) return *found;
  if (name == name_of(Engine::kOnnxRuntime)) {
    throw Error("this build has no ONNX Runtime: use the engine 'opencv' or 'auto', or run scripts/setup and build again");
  }
  throw Error(fmt::format("there is no inference engine '{}': use auto, onnxruntime or opencv", name));
}

std::string shortened(std::string_view message) {
  constexpr std::size_t kMaxLength = 300;
  return std::string(message.substr(0, kMaxLength));
}

Network::Network(const std::filesystem::path& weights, Engine engine, int threads)
    : inference_(load(weights, engine, threads > 0 ? threads : thread_count())) {}

}  // namespace panoptic
