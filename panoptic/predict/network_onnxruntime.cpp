// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#ifdef PANOPTIC_ONNXRUNTIME

#include <fmt/format.h>
#include <onnxruntime_cxx_api.h>

#include <memory>

#include "panoptic/error.h"
#include "panoptic/predict/inference.h"

#ifdef __SANITIZE_ADDRESS__
// ONNX Runtime keeps some bytes to the end of the process; what this project allocates is still checked.
extern "C" const char* __lsan_default_suppressions();  // asked for by the sanitizer
extern "C" const char* __lsan_default_suppressions() { return "leak:libonnxruntime.so"; }
#endif

namespace panoptic {
namespace {

class OnnxRuntimeNetwork {
 public:
  OnnxRuntimeNetwork(const std::filesystem::path& weights, int threads)
      : name_(weights.string()), session_(env_, weights.c_str(), session_options(threads)) {
    if (session_.GetInputCount() != 1) {
      throw Error(fmt::format("{}: the network has {} inputs; only networks with one image input are supported", name_,
                              session_.GetInputCount()));
    }
    const Ort::AllocatorWithDefaultOptions allocator;
    input_ = session_.GetInputNameAllocated(0, allocator).get();
    for (std::size_t i = 0; i < session_.GetOutputCount(); ++i) {
      outputs_.emplace_back(session_.GetOutputNameAllocated(i, allocator).get());
    }
  }

  std::vector<Tensor> run(const Tensor& input) {
    const std::vector<std::int64_t> shape(input.shape.begin(), input.shape.end());
    const auto memory = Ort::MemoryInfo::CreateCpu(OrtArenaAllocator, OrtMemTypeDefault);
    const auto value = Ort::Value::CreateTensor<float>(memory, const_cast<float*>(input.values.data()), input.values.size(),
                                                       shape.data(), shape.size());
    const char* const input_name = input_.c_str();
    std::vector<const char*> output_names;
    for (const std::string& output : outputs_) output_names.push_back(output.c_str());
    const auto values = session_.Run(Ort::RunOptions(), &input_name, &value, 1, output_names.data(), output_names.size());
    std::vector<Tensor> tensors;
    for (std::size_t i = 0; i < values.size(); ++i) tensors.push_back(to_tensor(values[i], outputs_[i]));
    return tensors;
  }

 private:
  static Ort::SessionOptions session_options(int threads) {
    Ort::SessionOptions options;
    options.SetIntraOpNumThreads(threads);
    options.SetGraphOptimizationLevel(ORT_ENABLE_ALL);
    // Idle workers would spin on the cores that fusion and decoding run on: 2.5 times slower where those are busy.
    options.AddConfigEntry("session.intra_op.allow_spinning", "0");
    return options;
  }

  Tensor to_tensor(const Ort::Value& value, const std::string& output) const {
    const auto type = value.GetTensorTypeAndShapeInfo();
    if (type.GetElementType() != ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT) {
      throw Error(
          fmt::format("{}: the output '{}' is not of 32-bit floats; export the network with float outputs", name_, output));
    }
    Tensor tensor;
    for (const std::int64_t extent : type.GetShape()) tensor.shape.push_back(static_cast<int>(extent));
    const float* data = value.GetTensorData<float>();
    tensor.values.assign(data, data + type.GetElementCount());
    return tensor;
  }

  std::string name_;
  Ort::Env env_{ORT_LOGGING_LEVEL_FATAL, "panoptic"};
  Ort::Session session_;
  std::string input_;
  std::vector<std::string> outputs_;
};

}  // namespace

Inference load_with_onnxruntime(const std::filesystem::path& weights, int threads) {
  try {
    const auto network = std::make_shared<OnnxRuntimeNetwork>(weights, threads);
    return [network, name = weights.string()](const Tensor& input) {
      try {
        return network->run(input);
      } catch (const Ort::Exception& e) {
        throw Error(fmt::format("{}: ONNX Runtime cannot run the network, does [input] fit it? {}", name, shortened(e.what())));
      }
    };
  } catch (const Ort::Exception& e) {
    throw Error(
        fmt::format("{}: ONNX Runtime cannot load it, is it a whole ONNX file? {}", weights.string(), shortened(e.what())));
  }
}

}  // namespace panoptic

#endif
