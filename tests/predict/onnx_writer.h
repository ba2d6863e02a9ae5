// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Writes small ONNX files of any graph: what exporters make, in a few hundred bytes.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "tests/predict/tiny_onnx.h"

namespace panoptic::test {

// Numbers of TensorProto.DataType.
inline constexpr unsigned kFloats = 1;
inline constexpr unsigned kBytes = 2;
inline constexpr unsigned kInt64s = 7;
inline constexpr unsigned kHalves = 10;
inline constexpr unsigned kDoubles = 11;

class OnnxWriter {
 public:
  explicit OnnxWriter(std::uint64_t operator_set = 13) : operator_set_(operator_set) {}

  // An extent of 0 is one that is not fixed.
  OnnxWriter& input(const std::string& name, const std::vector<int>& shape, unsigned type = kFloats) {
    graph_.bytes(11, value(name, shape, type));
    return *this;
  }
  OnnxWriter& output(const std::string& name, const std::vector<int>& shape, unsigned type = kFloats) {
    graph_.bytes(12, value(name, shape, type));
    return *this;
  }
  OnnxWriter& node(const std::string& operation, const std::vector<std::string>& from, const std::string& to,
                   const std::vector<std::string>& attributes = {}, const std::string& domain = "") {
    ProtoText node;
    for (const std::string& name : from) node.bytes(1, name);
    node.bytes(2, to).bytes(3, to).bytes(4, operation);
    for (const std::string& attribute : attributes) node.bytes(5, attribute);
    if (!domain.empty()) node.bytes(7, domain);
    graph_.bytes(1, node.text());
    return *this;
  }
  OnnxWriter& constant(const std::string& name, const std::vector<int>& shape, const std::vector<float>& values) {
    return tensor(name, shape, kFloats, raw(values));
  }
  OnnxWriter& constant(const std::string& name, const std::vector<int>& shape, const std::vector<std::int64_t>& values) {
    return tensor(name, shape, kInt64s, raw(values));
  }
  // Weights in a second file.
  OnnxWriter& external(const std::string& name, const std::vector<int>& shape, const std::string& file) {
    ProtoText tensor;
    for (const int extent : shape) tensor.integer(1, static_cast<std::uint64_t>(extent));
    const ProtoText place = ProtoText().bytes(1, "location").bytes(2, file);
    tensor.integer(2, kFloats).bytes(8, name).bytes(13, place.text()).integer(14, 1);
    graph_.bytes(5, tensor.text());
    return *this;
  }
  OnnxWriter& metadata(const std::string& key, const std::string& value) {
    metadata_.bytes(14, ProtoText().bytes(1, key).bytes(2, value).text());
    return *this;
  }

  std::string text() const {
    ProtoText graph = graph_;
    graph.bytes(2, "graph");
    return ProtoText()
               .integer(1, 8)
               .bytes(7, graph.text())
               .bytes(8, ProtoText().bytes(1, "").integer(2, operator_set_).text())
               .text() +
           metadata_.text();
  }

  static std::string integer_attribute(const std::string& name, std::uint64_t value) {
    return ProtoText().bytes(1, name).integer(3, value).integer(20, 2).text();
  }
  static std::string integers_attribute(const std::string& name, const std::vector<int>& values) {
    ProtoText attribute = ProtoText().bytes(1, name);
    for (const int v : values) attribute.integer(8, static_cast<std::uint64_t>(v));
    return attribute.integer(20, 7).text();
  }

 private:
  template <typename T>
  static std::string raw(const std::vector<T>& values) {
    std::string bytes(values.size() * sizeof(T), '\0');
    std::memcpy(bytes.data(), values.data(), bytes.size());
    return bytes;
  }
  OnnxWriter& tensor(const std::string& name, const std::vector<int>& shape, unsigned type, const std::string& bytes) {
    ProtoText tensor;
    for (const int extent : shape) tensor.integer(1, static_cast<std::uint64_t>(extent));
    graph_.bytes(5, tensor.integer(2, type).bytes(8, name).bytes(9, bytes).text());
    return *this;
  }
  static std::string value(const std::string& name, const std::vector<int>& shape, unsigned type) {
    ProtoText dims;
    for (const int extent : shape) {
      ProtoText dim;
      if (extent > 0) dim.integer(1, static_cast<std::uint64_t>(extent));
      if (extent == 0) dim.bytes(2, name + "_any");
      dims.bytes(1, dim.text());
    }
    const ProtoText tensor = ProtoText().integer(1, type).bytes(2, dims.text());
    return ProtoText().bytes(1, name).bytes(2, ProtoText().bytes(1, tensor.text()).text()).text();
  }

  std::uint64_t operator_set_;
  ProtoText graph_;
  ProtoText metadata_;
};

// A 1x1 convolution of an image to one plane per class; "y" are its logits.
inline OnnxWriter& classifier(OnnxWriter& writer, const std::string& from, const std::string& to,
                              const std::vector<float>& weights) {
  const int classes = static_cast<int>(weights.size() / 3);
  return writer.constant("weights", {classes, 3, 1, 1}, weights)
      .node("Conv", {from, "weights"}, to, {OnnxWriter::integers_attribute("kernel_shape", {1, 1})});
}

}  // namespace panoptic::test
