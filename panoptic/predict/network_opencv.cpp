// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/dnn.hpp>
#include <string_view>

#include "panoptic/error.h"
#include "panoptic/predict/inference.h"

namespace panoptic {
namespace {

// OpenCV prints what it also throws; one line on stderr is enough for the user.
class Quiet {
 public:
  Quiet() : before_(cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT)) {}
  ~Quiet() { cv::utils::logging::setLogLevel(before_); }
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

 private:
  cv::utils::logging::LogLevel before_;
};

// Operators that OpenCV 4.6 has not or not in full: numbers of results that depend on the image, subgraphs, sequences.
constexpr std::array<std::string_view, 12> kNotInOpenCv = {
    "If",         "Loop",      "NonMaxSuppression", "NonZero", "RoiAlign",
    "Scan",       "ScatterND", "SequenceConstruct", "TopK",    "SplitToSequence",
    "GridSample", "Einsum"};

// Without the fixed sizes that the file promises OpenCV drops and adds dimensions of 1.
void restore_shape(const OnnxValue& promised, Tensor& tensor) {
  std::size_t count = 1;
  for (const OnnxExtent& extent : promised.shape) count *= static_cast<std::size_t>(extent.size);
  if (!promised.has_shape || count != tensor.values.size()) return;
  tensor.shape.clear();
  for (const OnnxExtent& extent : promised.shape) tensor.shape.push_back(static_cast<int>(extent.size));
}

Tensor to_tensor(const cv::Mat& mat, const OnnxValue& promised) {
  cv::Mat whole;
  mat.convertTo(whole, CV_32F);
  Tensor tensor;
  for (int i = 0; i < whole.dims; ++i) tensor.shape.push_back(whole.size[i]);
  tensor.values.assign(whole.ptr<float>(), whole.ptr<float>() + whole.total());
  restore_shape(promised, tensor);
  return tensor;
}

// Outputs are asked for by name: OpenCV itself lists them in the order of the alphabet.
std::vector<Tensor> run(cv::dnn::Net& net, const OnnxFile& file, const Tensor& input) {
  const Quiet quiet;
  net.setInput(cv::Mat(input.shape, CV_32F, const_cast<float*>(input.values.data())));
  std::vector<cv::String> names;
  for (const OnnxValue& output : file.outputs) names.push_back(output.name);
  std::vector<cv::Mat> mats;
  net.forward(mats, names);
  std::vector<Tensor> tensors;
  for (std::size_t i = 0; i < mats.size(); ++i) tensors.push_back(to_tensor(mats[i], file.outputs[i]));
  return tensors;
}

}  // namespace

std::string why_not_opencv(const OnnxFile& file) {
  if (!file.external_files.empty()) return "its weights are in a second file";
  const OnnxValue& input = file.inputs.front();
  if (input.type != OnnxType::kFloat) return fmt::format("its input is of {}", text_of(input.type));
  if (!input.has_shape || input.shape.size() != 4) return "its input is not 1 x 3 x height x width";
  for (const OnnxValue& output : file.outputs) {
    if (output.type != OnnxType::kFloat) return fmt::format("its output '{}' is of {}", output.name, text_of(output.type));
  }
  for (const std::string& operation : file.operators) {
    if (operation.find("::") != std::string::npos) return fmt::format("it has the operator {}", operation);
    if (std::find(kNotInOpenCv.begin(), kNotInOpenCv.end(), operation) != kNotInOpenCv.end())
      return fmt::format("it has the operator {}", operation);
  }
  return "";
}

Inference load_with_opencv(const std::filesystem::path& weights, const OnnxFile& file, int threads) {
  const Quiet quiet;
  try {
    const auto net = std::make_shared<cv::dnn::Net>(cv::dnn::readNetFromONNX(weights.string()));
    if (net->empty()) throw Error(fmt::format("{}: the network is empty", weights.string()));
    cv::setNumThreads(threads);
    return [net, file, name = weights.string()](const Tensor& input) {
      try {
        return run(*net, file, input);
      } catch (const std::exception& e) {
        throw Error(
            fmt::format("{}: OpenCV cannot run the network, does [input] fit it? Else use networks.engine=onnxruntime. {}", name,
                        reason_in(e.what())));
      }
    };
  } catch (const cv::Exception& e) {
    throw Error(
        fmt::format("{}: OpenCV {} cannot load it; use networks.engine=onnxruntime, or export it for an older operator set. {}",
                    weights.string(), CV_VERSION, reason_in(e.err)));
  }
}

}  // namespace panoptic
