// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predict/network.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "panoptic/base/text.h"
#include "panoptic/error.h"
#include "panoptic/parallel.h"
#include "panoptic/predict/inference.h"

namespace panoptic {
namespace {

constexpr int kColors = 3;
constexpr std::uint64_t kMostNumbers = std::uint64_t{1} << 28;  // 400 masks over 800 x 800 pixels

void require_file(const std::filesystem::path& weights) {
  std::error_code error;
  if (std::filesystem::is_regular_file(weights, error)) return;
  throw Error(fmt::format("there is no network file {}: check the path in the model description", weights.string()));
}

void require_external_files(const std::filesystem::path& weights, const OnnxFile& file) {
  for (const std::string& name : file.external_files) {
    std::error_code error;
    const std::filesystem::path beside = weights.parent_path() / name;
    if (std::filesystem::is_regular_file(beside, error)) continue;
    throw Error(fmt::format(
        "{}: its weights are in a second file, {}, which is not there: copy it too, or export with the weights inside",
        weights.string(), beside.string()));
  }
}

bool is_called_channels(const std::string& symbol) {
  const std::string name = lower_case(symbol);
  return name == "c" || name.starts_with("channel");
}

bool may_be_colors(const OnnxExtent& extent) { return extent.size == 0 || extent.size == kColors; }

// Three channels first, unless they are last for certain: there are three there and not in front, or their name says so.
bool has_channels_last(const OnnxExtent& front, const OnnxExtent& back) {
  if (!may_be_colors(front)) return may_be_colors(back);
  if (front.size == kColors) return false;
  return back.size == kColors || is_called_channels(back.symbol);
}

NetworkInput input_of(const OnnxFile& file, const std::string& name) {
  if (file.inputs.size() != 1) {
    throw Error(
        fmt::format("{}: the network has {} inputs; only networks with one image input are supported", name, file.inputs.size()));
  }
  const OnnxValue& value = file.inputs.front();
  NetworkInput input;
  input.type = value.type;
  constexpr std::array kTypes = {OnnxType::kFloat, OnnxType::kHalf, OnnxType::kDouble, OnnxType::kUint8};
  if (!value.is_tensor || std::find(kTypes.begin(), kTypes.end(), value.type) == kTypes.end()) {
    throw Error(fmt::format("{}: its input '{}' is of {}; export it with an input of 32-bit floats", name, value.name,
                            value.is_tensor ? text_of(value.type) : "no tensor type"));
  }
  if (!value.has_shape) return input;
  const std::vector<OnnxExtent>& shape = value.shape;
  input.has_batch = shape.size() == 4;
  const std::size_t first = input.has_batch ? 1 : 0;
  if (shape.size() != 3 && shape.size() != 4) {
    throw Error(
        fmt::format("{}: its input '{}' is {}; an image is 1 x 3 x height x width, with or without the 1, or with the 3 last",
                    name, value.name, shape_text(shape)));
  }
  if (input.has_batch && shape[0].size > 1) {
    throw Error(fmt::format("{}: it was exported for batches of {} images; export it for one, or for batches of any size", name,
                            shape[0].size));
  }
  input.channels_last = has_channels_last(shape[first], shape.back());
  if (!may_be_colors(input.channels_last ? shape.back() : shape[first])) {
    throw Error(fmt::format("{}: its input '{}' is {}; only networks that take colour images, 3 channels, are supported", name,
                            value.name, shape_text(shape)));
  }
  input.height = static_cast<int>(shape[input.channels_last ? first : first + 1].size);
  input.width = static_cast<int>(shape[input.channels_last ? first + 1 : first + 2].size);
  return input;
}

void require_outputs(const OnnxFile& file, const std::string& name) {
  for (const OnnxValue& output : file.outputs) {
    if (!output.is_tensor) {
      throw Error(
          fmt::format("{}: its output '{}' is a sequence or a map, not a tensor; export the network with tensors as outputs",
                      name, output.name));
    }
    std::uint64_t numbers = 1;
    for (const OnnxExtent& extent : output.shape) {
      const std::uint64_t size = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(extent.size));
      numbers = numbers > kMostNumbers / size ? kMostNumbers + 1 : numbers * size;
    }
    require_size(numbers, output.name, name);
  }
}

// The image in the network's order of dimensions.
Tensor in_order_of(const NetworkInput& input, const Tensor& image) {
  Tensor result = image;
  const int height = image.shape[2];
  const int width = image.shape[3];
  if (input.channels_last) {
    result.shape = {1, height, width, kColors};
    const std::size_t plane = image.values.size() / kColors;
    for (std::size_t i = 0; i < plane; ++i) {
      for (std::size_t c = 0; c < kColors; ++c) result.values[i * kColors + c] = image.values[c * plane + i];
    }
  }
  if (!input.has_batch) result.shape.erase(result.shape.begin());
  return result;
}

Inference load(const std::filesystem::path& weights, const OnnxFile& file, Engine engine, int threads) {
#ifdef PANOPTIC_ONNXRUNTIME
  if (engine == Engine::kOnnxRuntime) return load_with_onnxruntime(weights, threads);
#endif
  if (engine != Engine::kOpenCv) throw Error(fmt::format("the engine {} is not built in; use opencv", name_of(engine)));
  if (const std::string why = why_not_opencv(file); !why.empty()) {
    throw Error(fmt::format("{}: the engine opencv is not used for this network, because {}; use networks.engine=onnxruntime",
                            weights.string(), why));
  }
  return load_with_opencv(weights, file, threads);
}

// Where the name of a source file of an engine begins, with the number of a line behind it: /onnxruntime_src/a/b.cc:56.
std::size_t source_place(std::string_view text, std::size_t& end) {
  for (const std::string_view ending : {".cc:", ".h:", ".cpp:", ".cu:", ".hpp:"}) {
    const std::size_t found = text.find(ending);
    if (found == std::string_view::npos) continue;
    end = std::min(text.find_first_not_of("0123456789", found + ending.size()), text.size());
    const std::size_t blank = text.find_last_of(" ,;'\"", found);
    const std::size_t slash = text.find('/', blank == std::string_view::npos ? 0 : blank);
    return std::min(slash, found);
  }
  return std::string_view::npos;
}

// Passes over the name and the arguments of a function: "void f(const T<int(int)>&, int) const ".
std::size_t behind_signature(std::string_view text) {
  const std::size_t open = text.find('(');
  if (open == std::string_view::npos) return 0;
  int depth = 0;
  for (std::size_t i = open; i < text.size(); ++i) {
    depth += text[i] == '(' ? 1 : text[i] == ')' ? -1 : 0;
    if (depth > 0) continue;
    const std::size_t behind = text.find_first_not_of(' ', i + 1);
    if (behind == std::string_view::npos) return text.size();
    constexpr std::string_view kConst = "const ";
    return text.substr(behind).starts_with(kConst) ? behind + kConst.size() : behind;
  }
  return 0;
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

void require_size(std::uint64_t numbers, const std::string& output, const std::string& network) {
  if (numbers <= kMostNumbers) return;
  throw Error(
      fmt::format("{}: its output '{}' has more than {} million numbers; export it for smaller images, or with less masks",
                  network, output, kMostNumbers >> 20));
}

std::string reason_in(std::string_view message) {
  constexpr std::size_t kMaxLength = 300;
  std::string text(message);
  if (text.starts_with("[ONNXRuntimeError]")) {
    const std::size_t code = text.find(" : ", text.find(" : ") + 1);
    const std::size_t name = code == std::string::npos ? code : text.find(" : ", code + 1);
    if (name != std::string::npos) text.erase(0, name + 3);
  }
  if (const std::size_t failed = text.find(" failed:"); text.starts_with("Load model from ") && failed != std::string::npos) {
    text.erase(0, failed + std::string_view(" failed:").size());
  }
  std::size_t end = 0;
  for (std::size_t begin = source_place(text, end); begin != std::string::npos; begin = source_place(text, end)) {
    const std::size_t reason = end + behind_signature(std::string_view(text).substr(end));
    text.erase(begin, reason - begin);
  }
  text.erase(0, std::min(text.find_first_not_of(" :\n"), text.size()));
  if (text.size() <= kMaxLength) return text;
  const std::size_t blank = text.rfind(' ', kMaxLength);
  return text.substr(0, blank == std::string::npos ? kMaxLength : blank) + " ...";
}

Network::Network(const std::filesystem::path& weights, Engine engine, int threads) : name_(weights.string()) {
  require_file(weights);
  file_ = read_onnx_file(weights);
  input_ = input_of(file_, name_);
  require_outputs(file_, name_);
  require_external_files(weights, file_);
  inference_ = load(weights, file_, engine, threads > 0 ? threads : thread_count());
}

std::vector<Tensor> Network::run(const Tensor& image) const {
  if (image.shape.size() != 4 || image.shape[0] != 1 || image.shape[1] != kColors) {
    throw Error(fmt::format("{}: the input must be one image, 1 x 3 x height x width", name_));
  }
  const bool fits =
      (input_.height == 0 || input_.height == image.shape[2]) && (input_.width == 0 || input_.width == image.shape[3]);
  if (!fits) {
    throw Error(
        fmt::format("{}: the network takes images of {} x {} pixels, [input] says {} x {}: correct width and height there", name_,
                    input_.width, input_.height, image.shape[3], image.shape[2]));
  }
  const bool as_it_is = !input_.channels_last && input_.has_batch;
  std::vector<Tensor> outputs = as_it_is ? inference_(image) : inference_(in_order_of(input_, image));
  for (std::size_t i = 0; i < outputs.size() && i < file_.outputs.size(); ++i) outputs[i].name = file_.outputs[i].name;
  return outputs;
}

}  // namespace panoptic
