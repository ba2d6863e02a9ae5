// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/ply_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <optional>
#include <utility>

#include "panoptic/error.h"

namespace panoptic {
namespace {

static_assert(std::endian::native == std::endian::little, "PLY numbers are copied as they lie in memory");

constexpr std::size_t kMaxHeaderBytes = 64U << 10;
constexpr std::size_t kMaxRecords = std::size_t{1} << 31;

constexpr std::array<std::pair<std::string_view, PlyType>, 16> kTypes = {{{"char", PlyType::kInt8},
                                                                          {"int8", PlyType::kInt8},
                                                                          {"uchar", PlyType::kUint8},
                                                                          {"uint8", PlyType::kUint8},
                                                                          {"short", PlyType::kInt16},
                                                                          {"int16", PlyType::kInt16},
                                                                          {"ushort", PlyType::kUint16},
                                                                          {"uint16", PlyType::kUint16},
                                                                          {"int", PlyType::kInt32},
                                                                          {"int32", PlyType::kInt32},
                                                                          {"uint", PlyType::kUint32},
                                                                          {"uint32", PlyType::kUint32},
                                                                          {"float", PlyType::kFloat},
                                                                          {"float32", PlyType::kFloat},
                                                                          {"double", PlyType::kDouble},
                                                                          {"float64", PlyType::kDouble}}};

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t begin = line.find_first_not_of(' '); begin != std::string_view::npos;) {
    const std::size_t end = std::min(line.find(' ', begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(' ', end);
  }
  return words;
}

bool is_whole(PlyType type) { return type != PlyType::kFloat && type != PlyType::kDouble; }

template <typename T>
double number_at(const char* bytes) {
  T value{};
  std::memcpy(&value, bytes, sizeof(T));
  return static_cast<double>(value);
}

class HeaderParser {
 public:
  HeaderParser(std::string_view text, const std::string& name) : text_(text), name_(name) {}

  PlyHeader parse() {
    if (next_line() != "ply") fail("is not 'ply'; this is no PLY file");
    const std::string_view format = next_line();
    if (format != "format binary_little_endian 1.0") {
      fail(fmt::format("is '{}'; save the mesh as binary little-endian PLY", format.substr(0, 64)));
    }
    for (std::string_view line = next_line(); line != "end_header"; line = next_line()) take(words_of(line));
    header_.bytes = at_;
    check_sizes();
    return std::move(header_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw Error(fmt::format("{}: line {} {}", name_, line_number_, what)); }

  std::string_view next_line() {
    const std::size_t end = text_.substr(0, kMaxHeaderBytes).find('\n', at_);
    if (end == std::string_view::npos) {
      throw Error(fmt::format("{}: the PLY header ends after line {} without end_header", name_, line_number_));
    }
    std::string_view line = text_.substr(at_, end - at_);
    if (line.ends_with('\r')) line.remove_suffix(1);
    at_ = end + 1;
    ++line_number_;
    return line;
  }

  void take(const std::vector<std::string_view>& words) {
    constexpr std::size_t kScalarWords = 3;
    constexpr std::size_t kListWords = 5;
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") return;
    if (words[0] == "element" && words.size() == 3) {
      header_.elements.push_back({std::string(words[1]), count_in(words[2]), {}, 0});
    } else if (words[0] == "property" && words.size() == kScalarWords) {
      add({std::string(words[2]), type_in(words[1])});
    } else if (words[0] == "property" && words.size() == kListWords && words[1] == "list") {
      const PlyType count_type = type_in(words[2]);
      if (!is_whole(count_type)) fail("counts a list with a type that is not whole");
      add({std::string(words[4]), type_in(words[3]), true, count_type});
    } else {
      fail("is neither element nor property");
    }
  }

  std::size_t count_in(std::string_view word) const {
    std::size_t count = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), count);
    if (error != std::errc() || end != word.data() + word.size() || count > kMaxRecords) {
      fail(fmt::format("has no usable count: '{}'", word.substr(0, 64)));
    }
    return count;
  }

  PlyType type_in(std::string_view word) const {
    const auto* at = std::find_if(kTypes.begin(), kTypes.end(), [&](const auto& entry) { return entry.first == word; });
    if (at == kTypes.end()) fail(fmt::format("has the unknown type '{}'", word.substr(0, 64)));
    return at->second;
  }

  void add(PlyProperty property) {
    if (header_.elements.empty()) fail("is a property before any element");
    PlyElement& element = header_.elements.back();
    property.offset = element.record_bytes;
    element.record_bytes += bytes_of(property.is_list ? property.count_type : property.type);
    element.properties.push_back(std::move(property));
  }

  // Before memory is taken. No overflow: counts are at most 2^31 and a header of 64 KiB gives records of less than 2^16 bytes.
  void check_sizes() const {
    std::size_t least = 0;
    for (const PlyElement& element : header_.elements) {
      least += element.count * element.record_bytes;
      if (element.count > 0 && element.record_bytes == 0) {
        throw Error(fmt::format("{}: the PLY element '{}' has records without properties", name_, element.name.substr(0, 64)));
      }
    }
    const std::size_t present = text_.size() - header_.bytes;
    if (least > present) {
      throw Error(fmt::format("{}: {} bytes follow the PLY header, which announces at least {}; the file is cut off", name_,
                              present, least));
    }
  }

  std::string_view text_;
  const std::string& name_;
  PlyHeader header_;
  std::size_t at_ = 0;
  int line_number_ = 0;
};

}  // namespace

std::size_t bytes_of(PlyType type) {
  constexpr std::array<std::size_t, 8> kBytes = {1, 1, 2, 2, 4, 4, 4, 8};
  return kBytes[static_cast<std::size_t>(type)];
}

double ply_number(PlyType type, const char* bytes) {
  switch (type) {
    case PlyType::kInt8:
      return number_at<std::int8_t>(bytes);
    case PlyType::kUint8:
      return number_at<std::uint8_t>(bytes);
    case PlyType::kInt16:
      return number_at<std::int16_t>(bytes);
    case PlyType::kUint16:
      return number_at<std::uint16_t>(bytes);
    case PlyType::kInt32:
      return number_at<std::int32_t>(bytes);
    case PlyType::kUint32:
      return number_at<std::uint32_t>(bytes);
    case PlyType::kFloat:
      return number_at<float>(bytes);
    case PlyType::kDouble:
      return number_at<double>(bytes);
  }
  return 0;
}

bool PlyElement::has_list() const {
  return std::any_of(properties.begin(), properties.end(), [](const PlyProperty& p) { return p.is_list; });
}

const PlyProperty* PlyElement::find(std::string_view property) const {
  const auto at = std::find_if(properties.begin(), properties.end(), [&](const PlyProperty& p) { return p.name == property; });
  return at == properties.end() ? nullptr : &*at;
}

PlyHeader parse_ply_header(std::string_view text, const std::string& name) { return HeaderParser(text, name).parse(); }

}  // namespace panoptic
