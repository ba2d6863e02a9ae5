// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Real ONNX files of a few hundred bytes: one 1x1 convolution that turns colours into logits.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace panoptic::test {

// The few pieces of the protocol-buffer encoding that an ONNX file needs.
class ProtoText {
 public:
  ProtoText& integer(unsigned field, std::uint64_t value) {
    varint(field << 3);
    varint(value);
    return *this;
  }
  ProtoText& bytes(unsigned field, const std::string& value) {
    varint(field << 3 | 2);
    varint(value.size());
    text_ += value;
    return *this;
  }
  const std::string& text() const { return text_; }

 private:
  void varint(std::uint64_t value) {
    for (; value >= 128; value >>= 7) text_.push_back(static_cast<char>(value % 128 + 128));
    text_.push_back(static_cast<char>(value));
  }

  std::string text_;
};

inline std::string value_text(const std::string& name, const std::vector<int>& shape) {
  ProtoText dims;
  for (const int extent : shape) dims.bytes(1, ProtoText().integer(1, static_cast<std::uint64_t>(extent)).text());
  const ProtoText tensor = ProtoText().integer(1, 1).bytes(2, dims.text());
  return ProtoText().bytes(1, name).bytes(2, ProtoText().bytes(1, tensor.text()).text()).text();
}

// logits[c] = sum over the three channels of weights[3 * c + channel] * value, for an input 1 x 3 x height x width.
inline std::string color_classifier(int width, int height, const std::vector<float>& weights) {
  const int classes = static_cast<int>(weights.size() / 3);
  std::string raw(weights.size() * sizeof(float), '\0');
  std::memcpy(raw.data(), weights.data(), raw.size());
  ProtoText initializer;
  for (const int extent : {classes, 3, 1, 1}) initializer.integer(1, static_cast<std::uint64_t>(extent));
  initializer.integer(2, 1).bytes(8, "weights").bytes(9, raw);
  const ProtoText kernel = ProtoText().bytes(1, "kernel_shape").integer(8, 1).integer(8, 1).integer(20, 7);
  const ProtoText node = ProtoText()
                             .bytes(1, "image")
                             .bytes(1, "weights")
                             .bytes(2, "logits")
                             .bytes(3, "conv")
                             .bytes(4, "Conv")
                             .bytes(5, kernel.text());
  const ProtoText graph = ProtoText()
                              .bytes(1, node.text())
                              .bytes(2, "tiny")
                              .bytes(5, initializer.text())
                              .bytes(11, value_text("image", {1, 3, height, width}))
                              .bytes(12, value_text("logits", {1, classes, height, width}));
  return ProtoText().integer(1, 8).bytes(7, graph.text()).bytes(8, ProtoText().bytes(1, "").integer(2, 13).text()).text();
}

}  // namespace panoptic::test
