// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/dnn.hpp>

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

Tensor to_tensor(const cv::Mat& mat) {
  Tensor tensor;
  for (int i = 0; i < mat.dims; ++i) tensor.shape.push_back(mat.size[i]);
  const cv::Mat whole = mat.isContinuous() ? mat : mat.clone();
  tensor.values.assign(whole.ptr<float>(), whole.ptr<float>() + whole.total());
  return tensor;
}

// OpenCV 4.6 lists the output layers in the order of the ONNX graph's outputs.
std::vector<Tensor> run(cv::dnn::Net& net, const std::vector<cv::String>& outputs, const Tensor& input) {
  const Quiet quiet;
  net.setInput(cv::Mat(input.shape, CV_32F, const_cast<float*>(input.values.data())));
  std::vector<cv::Mat> mats;
  net.forward(mats, outputs);
  std::vector<Tensor> tensors;
  for (const cv::Mat& mat : mats) {
    if (mat.type() != CV_32F) throw Error("an output is not of 32-bit floats");
    tensors.push_back(to_tensor(mat));
  }
  return tensors;
}

}  // namespace

Inference load_with_opencv(const std::filesystem::path& weights, int threads) {
  const Quiet quiet;
  try {
    const auto net = std::make_shared<cv::dnn::Net>(cv::dnn::readNetFromONNX(weights.string()));
    if (net->empty()) throw Error(fmt::format("{}: the network is empty", weights.string()));
    cv::setNumThreads(threads);
    return [net, outputs = net->getUnconnectedOutLayersNames(), name = weights.string()](const Tensor& input) {
      try {
        return run(*net, outputs, input);
      } catch (const std::exception& e) {
        throw Error(fmt::format("{}: OpenCV cannot run the network, does [input] fit it? {}", name, shortened(e.what())));
      }
    };
  } catch (const cv::Exception& e) {
    throw Error(fmt::format("{}: OpenCV cannot load it, is it a whole ONNX file that OpenCV {} supports? {}", weights.string(),
                            CV_VERSION, shortened(e.err)));
  }
}

}  // namespace panoptic
