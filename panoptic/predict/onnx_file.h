// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The interface of a network as its ONNX file states it: the facts that no engine tells in words, and that both engines must
// agree on.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace panoptic {

// The numbers of onnx.proto's TensorProto.DataType that are read here.
enum class OnnxType : int {
  kNone = 0,
  kFloat = 1,
  kUint8 = 2,
  kInt8 = 3,
  kInt32 = 6,
  kInt64 = 7,
  kBool = 9,
  kHalf = 10,
  kDouble = 11
};

struct OnnxExtent {
  std::int64_t size = 0;  // 0: not fixed
  std::string symbol;     // its name, where it is not fixed and has one
};

struct OnnxValue {
  std::string name;
  bool is_tensor = false;  // false: a sequence, a map or an optional
  OnnxType type = OnnxType::kNone;
  bool has_shape = false;
  std::vector<OnnxExtent> shape;
};

struct OnnxFile {
  std::vector<OnnxValue> inputs;  // without those that are weights
  std::vector<OnnxValue> outputs;
  std::map<std::string, std::string> metadata;
  std::int64_t operator_set = 0;            // of ONNX's own operators
  std::set<std::string> operators;          // "Conv"; "mmdeploy::MMCVRoiAlign" where it is not one of ONNX's own
  std::vector<std::string> external_files;  // beside the ONNX file, with weights
};

// Reads and checks a file; weights are passed over. Throws Error naming the file and what it is instead (a pointer of Git LFS, a
// PyTorch checkpoint), or that it ends too early.
OnnxFile read_onnx_file(const std::filesystem::path& path);

// The same for the bytes of a file; `name` is for the text of an Error.
OnnxFile parse_onnx(std::string_view bytes, const std::string& name);

// "1 x 3 x height x 640".
std::string shape_text(const std::vector<OnnxExtent>& shape);

// "32-bit floats".
std::string_view text_of(OnnxType type);

}  // namespace panoptic
