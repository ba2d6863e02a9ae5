// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The message /api/chunks as a page reads it, by docs/viewer_protocol.md alone.
#pragma once

#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "panoptic/labels.h"
#include "panoptic/voxel_map.h"

namespace panoptic::test {

struct DecodedVertex {
  std::array<std::uint16_t, 3> steps;
  std::uint16_t id;  // which of the chunk's
  std::array<std::int8_t, 3> normal;
  std::uint8_t confidence;
  std::array<std::uint8_t, 3> color;
  std::uint8_t zero;
};
static_assert(sizeof(DecodedVertex) == 16);

struct DecodedChunk {
  BlockIndex block;
  std::uint64_t version = 0;
  std::vector<PanopticId> ids;
  std::vector<DecodedVertex> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

class MessageReader {
 public:
  explicit MessageReader(const std::string& bytes) : bytes_(bytes) {}
  template <typename T>
  T take() {
    T value{};
    if (left() < sizeof(T)) throw std::runtime_error("the message is cut off");
    std::memcpy(&value, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }
  const unsigned char* take_padded(std::size_t count) {
    const auto* from = reinterpret_cast<const unsigned char*>(bytes_.data()) + at_;
    const std::size_t padded = (count + 3) / 4 * 4;
    if (left() < padded) throw std::runtime_error("the message is cut off");
    for (std::size_t i = count; i < padded; ++i) EXPECT_EQ(from[i], 0);
    at_ += padded;
    return from;
  }
  std::size_t left() const { return bytes_.size() - at_; }

 private:
  const std::string& bytes_;
  std::size_t at_ = 0;
};

inline std::vector<DecodedChunk> decoded(const std::string& message) {
  MessageReader reader(message);
  EXPECT_EQ(reader.take<std::uint32_t>(), 0x32434650U) << "PFC2";
  std::vector<DecodedChunk> chunks(reader.take<std::uint32_t>());
  for (DecodedChunk& chunk : chunks) {
    chunk.block.x = reader.take<std::int32_t>();
    chunk.block.y = reader.take<std::int32_t>();
    chunk.block.z = reader.take<std::int32_t>();
    chunk.vertices.resize(reader.take<std::uint32_t>());
    chunk.triangles.resize(reader.take<std::uint32_t>());
    chunk.version = reader.take<std::uint64_t>();
    const auto vertex_bytes = reader.take<std::uint32_t>();
    const auto index_bytes = reader.take<std::uint32_t>();
    const auto id_count = reader.take<std::uint32_t>();
    const unsigned char* vertices = reader.take_padded(vertex_bytes);
    const unsigned char* indices = reader.take_padded(index_bytes);
    for (std::uint32_t i = 0; i < id_count; ++i) chunk.ids.push_back(PanopticId{reader.take<std::uint32_t>()});
    if (chunk.triangles.empty()) {
      EXPECT_EQ(vertex_bytes + index_bytes + id_count + chunk.vertices.size(), 0U);
      continue;
    }
    EXPECT_EQ(vertices[0], 0xA0) << "the version of vertex streams that EXT_meshopt_compression has";
    EXPECT_EQ(indices[0], 0xE1) << "the version of index streams";
    EXPECT_EQ(meshopt_decodeVertexBuffer(chunk.vertices.data(), chunk.vertices.size(), 16, vertices, vertex_bytes), 0);
    EXPECT_EQ(meshopt_decodeIndexBuffer(chunk.triangles.data(), chunk.triangles.size() * 3, 4, indices, index_bytes), 0);
  }
  EXPECT_EQ(reader.left(), 0U);
  return chunks;
}

}  // namespace panoptic::test
