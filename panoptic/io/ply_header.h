// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The header of a binary little-endian PLY file: which elements follow, and how their bytes lie.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace panoptic {

enum class PlyType : std::uint8_t { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

std::size_t bytes_of(PlyType type);

// The number at these bytes; exact for every type.
double ply_number(PlyType type, const char* bytes);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat;
  bool is_list = false;
  PlyType count_type = PlyType::kUint8;  // of a list
  std::size_t offset = 0;                // from the start of a record; only meaningful where no list is in the element
};

struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;
  std::size_t record_bytes = 0;  // without what lists hold: the least that a record takes

  bool has_list() const;
  const PlyProperty* find(std::string_view property) const;  // nullptr if there is none
};

struct PlyHeader {
  std::vector<PlyElement> elements;
  std::size_t bytes = 0;  // where the data begins
};

// Throws Error, beginning with `name`, unless the text starts with such a header and the bytes behind it can hold the elements.
PlyHeader parse_ply_header(std::string_view text, const std::string& name);

}  // namespace panoptic
