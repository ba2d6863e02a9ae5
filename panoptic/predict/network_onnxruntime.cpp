// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#ifdef PANOPTIC_ONNXRUNTIME

#include <fmt/format.h>
#include <onnxruntime_cxx_api.h>

#include <algorithm>
#include <cstdint>
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
    const Ort::AllocatorWithDefaultOptions allocator;
    input_ = session_.GetInputNameAllocated(0, allocator).get();
    type_ = session_.GetInputTypeInfo(0).GetTensorTypeAndShapeInfo().GetElementType();
    for (std::size_t i = 0; i < session_.GetOutputCount(); ++i) {
      outputs_.emplace_back(session_.GetOutputNameAllocated(i, allocator).get());
    }
  }

  std::vector<Tensor> run(const Tensor& input) {
    const std::vector<std::int64_t> shape(input.shape.begin(), input.shape.end());
    const Ort::Value value = to_value(input, shape);
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

  // Floats go in without a copy, other numbers are converted.
  Ort::Value to_value(const Tensor& input, const std::vector<std::int64_t>& shape) const {
    switch (type_) {
      case ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT16:
        return converted<Ort::Float16_t>(input, shape);
      case ONNX_TENSOR_ELEMENT_DATA_TYPE_DOUBLE:
        return converted<double>(input, shape);
      case ONNX_TENSOR_ELEMENT_DATA_TYPE_UINT8:
        return converted<std::uint8_t>(input, shape);
      default:
        break;
    }
    const auto memory = Ort::MemoryInfo::CreateCpu(OrtArenaAllocator, OrtMemTypeDefault);
    return Ort::Value::CreateTensor<float>(memory, const_cast<float*>(input.values.data()), input.values.size(), shape.data(),
                                           shape.size());
  }

  template <typename Number>
  static Ort::Value converted(const Tensor& input, const std::vector<std::int64_t>& shape) {
    const Ort::AllocatorWithDefaultOptions allocator;
    Ort::Value value = Ort::Value::CreateTensor<Number>(allocator, shape.data(), shape.size());
    std::transform(input.values.begin(), input.values.end(), value.GetTensorMutableData<Number>(),
                   [](float number) { return static_cast<Number>(number); });
    return value;
  }

  template <typename Number>
  static void copy(const Ort::Value& value, Tensor& tensor) {
    const Number* data = value.GetTensorData<Number>();
    for (float& number : tensor.values) number = static_cast<float>(*data++);
  }

  Tensor to_tensor(const Ort::Value& value, const std::string& output) const {
    const auto type = value.GetTensorTypeAndShapeInfo();
    require_size(type.GetElementCount(), output, name_);
    Tensor tensor;
    for (const std::int64_t extent : type.GetShape()) tensor.shape.push_back(static_cast<int>(extent));
    tensor.values.resize(type.GetElementCount());
    tensor.is_whole = true;
    switch (type.GetElementType()) {
      case ONNX_TENSOR_ELEMENT_DATA_TYPE_UINT8:
        copy<std::uint8_t>(value, tensor);
        return tensor;
      case ONNX_TENSOR_ELEMENT_DATA_TYPE_INT8:
        copy<std::int8_t>(value, tensor);
        return tensor;
      case ONNX_TENSOR_ELEMENT_DATA_TYPE_UINT16:
        copy<std::uint16_t>(value, tensor);
        return tensor;
      case ONNX_TENSOR_ELEMENT_DATA_TYPE_INT16:
        copy<std::int16_t>(value, tensor);
        return tensor;
      case ONNX_TENSOR_ELEMENT_DATA_TYPE_INT32:
        copy<std::int32_t>(value, tensor);
        return tensor;
      case ONNX_TENSOR_ELEMENT_DATA_TYPE_INT64:
        copy<std::int64_t>(value, tensor);
        return tensor;
      case ONNX_TENSOR_ELEMENT_DATA_TYPE_BOOL:
        copy<bool>(value, tensor);
        return tensor;
      default:
        tensor.is_whole = false;
    }
    switch (type.GetElementType()) {
      case ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT:
        copy<float>(value, tensor);
        return tensor;
      case ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT16:
        copy<Ort::Float16_t>(value, tensor);
        return tensor;
      case ONNX_TENSOR_ELEMENT_DATA_TYPE_DOUBLE:
        copy<double>(value, tensor);
        return tensor;
      default:
        throw Error(fmt::format("{}: its output '{}' holds neither floats nor integers; export it with floats", name_, output));
    }
  }

  std::string name_;
  Ort::Env env_{ORT_LOGGING_LEVEL_FATAL, "panoptic"};
  Ort::Session session_;
  std::string input_;
  ONNXTensorElementDataType type_ = ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT;
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
        throw Error(fmt::format("{}: ONNX Runtime cannot run the network, does [input] fit it? {}", name, reason_in(e.what())));
      }
    };
  } catch (const Ort::Exception& e) {
    throw Error(fmt::format("{}: ONNX Runtime cannot load it, is it a whole ONNX file? It says: {}", weights.string(),
                            reason_in(e.what())));
  }
}

}  // namespace panoptic

#endif
