// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The one seam to inference engines: a network is a file of weights that turns one tensor into several.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "panoptic/predict/onnx_file.h"

namespace panoptic {

enum class Engine { kOnnxRuntime, kOpenCv };

// The engines of this build, the fastest first. OpenCV DNN is always there.
std::vector<Engine> built_in_engines();

// "onnxruntime" and "opencv" are engines, "auto" is the fastest of this build. Throws Error for any other name and for an
// engine that was not built in.
Engine engine_from(std::string_view name);
std::string_view name_of(Engine engine);

// Numbers row-major, the last dimension fastest; images are N x C x H x W.
struct Tensor {
  std::vector<int> shape;
  std::vector<float> values;
  std::string name = {};  // of a network's output
  bool is_whole = false;  // the network gives integers or booleans
};

// The image that a network takes, as far as its file says.
struct NetworkInput {
  int width = 0;  // 0: any
  int height = 0;
  bool channels_last = false;
  bool has_batch = true;
  OnnxType type = OnnxType::kFloat;  // floats, or bytes: pixels as they are
};

// Not thread-safe: one run at a time.
class Network {
 public:
  // Loads an ONNX file. threads = 0: as many as parallel_for uses. With OpenCV the number of threads is one for the whole
  // process: the last network loaded decides. Throws Error if the file is absent, takes something else than one colour image, or
  // the engine cannot use it.
  Network(const std::filesystem::path& weights, Engine engine, int threads = 0);

  // Output tensors in the order of the ONNX graph. The image is 1 x 3 x height x width, whatever order the network wants. Throws
  // Error if it does not fit the network.
  std::vector<Tensor> run(const Tensor& image) const;

  const NetworkInput& input() const { return input_; }
  const OnnxFile& file() const { return file_; }

 private:
  std::string name_;
  OnnxFile file_;
  NetworkInput input_;
  std::function<std::vector<Tensor>(const Tensor&)> inference_;
};

}  // namespace panoptic
