// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Field numbers are those of onnx.proto (https://github.com/onnx/onnx), the encoding is that of protocol buffers.
#include "panoptic/predict/onnx_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>

#include "panoptic/base/files.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{2} << 30;  // protocol buffers end there
constexpr int kMaxDepth = 16;                                      // graphs within nodes within graphs
constexpr std::size_t kMaxRank = 16;

struct NotProtobuf {};  // thrown here and caught here

// One field of a message: a number, or bytes.
struct ProtoField {
  std::uint64_t number = 0;
  std::uint64_t value = 0;
  std::string_view bytes;
};

class ProtoReader {
 public:
  explicit ProtoReader(std::string_view text) : text_(text) {}

  bool next(ProtoField& field) {
    if (text_.empty()) return false;
    const std::uint64_t key = varint();
    field = {key >> 3, 0, {}};
    switch (key & 7) {
      case 0:
        field.value = varint();
        break;
      case 1:
        field.bytes = take(8);
        break;
      case 2:
        field.bytes = take(varint());
        break;
      case 5:
        field.bytes = take(4);
        break;
      default:
        throw NotProtobuf();
    }
    if (field.number == 0) throw NotProtobuf();
    return true;
  }

 private:
  std::uint64_t varint() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 64; shift += 7) {
      const auto byte = static_cast<unsigned char>(take(1)[0]);
      value |= static_cast<std::uint64_t>(byte & 127U) << shift;
      if (byte < 128) return value;
    }
    throw NotProtobuf();
  }

  std::string_view take(std::uint64_t count) {
    if (count > text_.size()) throw NotProtobuf();
    const std::string_view taken = text_.substr(0, count);
    text_.remove_prefix(count);
    return taken;
  }

  std::string_view text_;
};

void for_each_field(std::string_view message, const std::function<void(const ProtoField&)>& action) {
  ProtoReader reader(message);
  for (ProtoField field; reader.next(field);) action(field);
}

// StringStringEntryProto, and OperatorSetIdProto's pair of domain and version.
std::pair<std::string, std::string> key_and_value(std::string_view message) {
  std::pair<std::string, std::string> entry;
  for_each_field(message, [&](const ProtoField& field) {
    if (field.number == 1) entry.first = field.bytes;
    if (field.number == 2) entry.second = field.bytes;
  });
  return entry;
}

void read_tensor_type(std::string_view message, OnnxValue& value) {
  value.is_tensor = true;
  for_each_field(message, [&](const ProtoField& field) {
    if (field.number == 1) value.type = static_cast<OnnxType>(field.value);
    if (field.number != 2) return;
    value.has_shape = true;
    for_each_field(field.bytes, [&](const ProtoField& dimension) {
      if (dimension.number != 1 || value.shape.size() >= kMaxRank) return;
      OnnxExtent extent;
      for_each_field(dimension.bytes, [&](const ProtoField& part) {
        if (part.number == 1) extent.size = std::max<std::int64_t>(0, static_cast<std::int64_t>(part.value));
        if (part.number == 2) extent.symbol = part.bytes;
      });
      value.shape.push_back(std::move(extent));
    });
  });
}

OnnxValue read_value(std::string_view message) {
  OnnxValue value;
  for_each_field(message, [&](const ProtoField& field) {
    if (field.number == 1) value.name = field.bytes;
    if (field.number != 2) return;
    for_each_field(field.bytes, [&](const ProtoField& kind) {
      if (kind.number == 1) read_tensor_type(kind.bytes, value);
    });
  });
  return value;
}

class OnnxReader {
 public:
  OnnxFile read(std::string_view message) {
    for_each_field(message, [&](const ProtoField& field) {
      if (field.number == 7) read_graph(field.bytes, 0);
      if (field.number == 8) read_operator_set(field.bytes);
      if (field.number == 14) file_.metadata.insert(key_and_value(field.bytes));
    });
    std::erase_if(file_.inputs, [&](const OnnxValue& value) { return weights_.contains(value.name); });
    return std::move(file_);
  }

 private:
  void read_operator_set(std::string_view message) {
    std::string domain;
    std::uint64_t version = 0;
    for_each_field(message, [&](const ProtoField& field) {
      if (field.number == 1) domain = field.bytes;
      if (field.number == 2) version = field.value;
    });
    if (domain.empty() || domain == "ai.onnx") file_.operator_set = static_cast<std::int64_t>(version);
  }

  void read_graph(std::string_view message, int depth) {
    if (depth > kMaxDepth) throw NotProtobuf();
    for_each_field(message, [&](const ProtoField& field) {
      if (field.number == 1) read_node(field.bytes, depth);
      if (field.number == 5) read_tensor(field.bytes);
      if (depth == 0 && field.number == 11) file_.inputs.push_back(read_value(field.bytes));
      if (depth == 0 && field.number == 12) file_.outputs.push_back(read_value(field.bytes));
    });
  }

  void read_node(std::string_view message, int depth) {
    std::string operation;
    std::string domain;
    for_each_field(message, [&](const ProtoField& field) {
      if (field.number == 4) operation = field.bytes;
      if (field.number == 7) domain = field.bytes;
      if (field.number == 5) read_attribute(field.bytes, depth);
    });
    file_.operators.insert(domain.empty() || domain == "ai.onnx" ? operation : domain + "::" + operation);
  }

  void read_attribute(std::string_view message, int depth) {
    for_each_field(message, [&](const ProtoField& field) {
      if (field.number == 5) read_tensor(field.bytes);
      if (field.number == 6 || field.number == 11) read_graph(field.bytes, depth + 1);
    });
  }

  void read_tensor(std::string_view message) {
    for_each_field(message, [&](const ProtoField& field) {
      if (field.number == 8) weights_.emplace(field.bytes);
      if (field.number != 13) return;
      const auto [key, value] = key_and_value(field.bytes);
      const bool known = std::find(file_.external_files.begin(), file_.external_files.end(), value) != file_.external_files.end();
      if (key == "location" && !known) file_.external_files.push_back(value);
    });
  }

  OnnxFile file_;
  std::set<std::string> weights_;
};

// The kind of a file that people take for an ONNX file; empty if it is nothing of the kind.
std::string mistaken_for_onnx(std::string_view bytes) {
  if (bytes.starts_with("version https://git-lfs")) return "it is a pointer of Git LFS, not the file itself: run git lfs pull";
  if (bytes.starts_with("PK\x03\x04")) {
    return "it is a ZIP archive, as PyTorch's checkpoints are: export the network to ONNX (torch.onnx.export)";
  }
  if (bytes.starts_with("<!DOCTYPE") || bytes.starts_with("<html")) return "it is a web page: download the file itself";
  return "";
}

}  // namespace

OnnxFile parse_onnx(std::string_view bytes, const std::string& name) {
  if (const std::string what = mistaken_for_onnx(bytes); !what.empty()) {
    throw Error(fmt::format("{} is not a whole ONNX file: {}", name, what));
  }
  try {
    OnnxFile file = OnnxReader().read(bytes);
    if (!file.outputs.empty()) return file;
  } catch (const NotProtobuf&) {  // told below
  }
  throw Error(
      fmt::format("{} is not a whole ONNX file: it ends too early, or is of another kind ({} bytes); copy or export it again",
                  name, bytes.size()));
}

OnnxFile read_onnx_file(const std::filesystem::path& path) { return parse_onnx(read_file(path, kMaxFileBytes), path.string()); }

std::string shape_text(const std::vector<OnnxExtent>& shape) {
  std::vector<std::string> parts;
  for (const OnnxExtent& extent : shape) {
    if (extent.size > 0)
      parts.push_back(fmt::format("{}", extent.size));
    else
      parts.push_back(extent.symbol.empty() ? "?" : extent.symbol);
  }
  return parts.empty() ? "one number" : fmt::format("{}", fmt::join(parts, " x "));
}

std::string_view text_of(OnnxType type) {
  switch (type) {
    case OnnxType::kFloat:
      return "32-bit floats";
    case OnnxType::kHalf:
      return "16-bit floats";
    case OnnxType::kDouble:
      return "64-bit floats";
    case OnnxType::kUint8:
      return "bytes";
    case OnnxType::kInt8:
      return "signed bytes";
    case OnnxType::kInt32:
      return "32-bit integers";
    case OnnxType::kInt64:
      return "64-bit integers";
    case OnnxType::kBool:
      return "booleans";
    case OnnxType::kNone:
      break;
  }
  return "another type";
}

}  // namespace panoptic
