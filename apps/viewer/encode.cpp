// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/encode.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>
#include <vector>

#include "panoptic/map/block_key.h"

namespace panoptic {
namespace {

static_assert(std::endian::native == std::endian::little, "messages are copied from memory");

// A vertex as docs/viewer_protocol.md draws it.
struct WireVertex {
  std::array<std::uint16_t, 3> position;
  std::uint16_t id;  // which of the chunk's ids
  std::array<std::int8_t, 3> normal;
  std::uint8_t confidence;
  std::array<std::uint8_t, 3> color;
  std::uint8_t zero;
};
static_assert(sizeof(WireVertex) == 16);

struct WireHead {
  std::array<std::int32_t, 3> block;
  std::uint32_t vertices;
  std::uint32_t triangles;
  std::array<std::uint32_t, 2> version;  // low, high: a 64-bit number here would be padded
  std::uint32_t vertex_bytes;
  std::uint32_t index_bytes;
  std::uint32_t id_count;
};
static_assert(sizeof(WireHead) == 40);

// The versions of the streams that EXT_meshopt_compression defines.
const bool kVersionsAreSet = [] {
  meshopt_encodeVertexVersion(0);
  meshopt_encodeIndexVersion(1);
  return true;
}();

std::uint16_t steps_from(std::int32_t block, float position_m, double step_m) {
  const double steps = std::round(position_m / step_m) - static_cast<double>(block) * kStepsPerBlock;
  return static_cast<std::uint16_t>(std::clamp(steps, 0.0, 65535.0));
}

// The ids in a chunk, ascending.
std::vector<PanopticId> ids_of(const MeshChunk& chunk) {
  std::vector<PanopticId> ids;
  for (const ChunkVertex& v : chunk.vertices) {
    if (ids.empty() || ids.back() != v.panoptic_id) ids.push_back(v.panoptic_id);
  }
  std::ranges::sort(ids);
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  return ids;
}

// All but the id.
WireVertex wire_vertex(const ChunkVertex& v, const Vec3f& normal, BlockIndex block, double step_m) {
  const auto byte = [](float n) { return static_cast<std::int8_t>(std::lround(std::clamp(n, -1.0F, 1.0F) * 127.0F)); };
  return {{steps_from(block.x, v.position.x(), step_m), steps_from(block.y, v.position.y(), step_m),
           steps_from(block.z, v.position.z(), step_m)},
          0,
          {byte(normal.x()), byte(normal.y()), byte(normal.z())},
          v.confidence,
          {v.color.r, v.color.g, v.color.b},
          0};
}

void append_padded(std::string& text, const std::vector<unsigned char>& bytes, std::size_t count) {
  text.append(reinterpret_cast<const char*>(bytes.data()), count);
  text.resize((text.size() + 3) / 4 * 4, '\0');
}

template <typename T>
void append_raw(std::string& text, const T& value) {
  text.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

}  // namespace

std::string encode_chunk(const SnapshotSurface& surface, std::size_t chunk, float block_size_m) {
  const SnapshotChunk& own = surface.snapshot().chunks[chunk];
  const double step_m = double{block_size_m} / kStepsPerBlock;
  const std::vector<Vec3f> normals = surface.normals(chunk);
  const std::vector<PanopticId> ids = ids_of(*own.surface);
  std::vector<WireVertex> vertices;
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const ChunkVertex& vertex = own.surface->vertices[i];
    vertices.push_back(wire_vertex(vertex, normals[i], own.index, step_m));
    vertices.back().id = static_cast<std::uint16_t>(std::ranges::lower_bound(ids, vertex.panoptic_id) - ids.begin());
  }
  std::vector<unsigned int> indices;
  for (const auto& t : own.surface->triangles) indices.insert(indices.end(), t.begin(), t.end());
  WireHead head{};
  head.block = {own.index.x, own.index.y, own.index.z};
  const std::uint64_t version = surface.version(chunk);
  head.version = {static_cast<std::uint32_t>(version), static_cast<std::uint32_t>(version >> 32)};
  std::vector<unsigned char> vertex_bytes;
  std::vector<unsigned char> index_bytes;
  if (kVersionsAreSet && !indices.empty()) {
    meshopt_optimizeVertexCache(indices.data(), indices.data(), indices.size(), vertices.size());
    const std::size_t used = meshopt_optimizeVertexFetch(vertices.data(), indices.data(), indices.size(), vertices.data(),
                                                         vertices.size(), sizeof(WireVertex));
    vertex_bytes.resize(meshopt_encodeVertexBufferBound(used, sizeof(WireVertex)));
    index_bytes.resize(meshopt_encodeIndexBufferBound(indices.size(), used));
    head.id_count = static_cast<std::uint32_t>(ids.size());
    head.vertices = static_cast<std::uint32_t>(used);
    head.triangles = static_cast<std::uint32_t>(indices.size() / 3);
    head.vertex_bytes = static_cast<std::uint32_t>(
        meshopt_encodeVertexBuffer(vertex_bytes.data(), vertex_bytes.size(), vertices.data(), used, sizeof(WireVertex)));
    head.index_bytes = static_cast<std::uint32_t>(
        meshopt_encodeIndexBuffer(index_bytes.data(), index_bytes.size(), indices.data(), indices.size()));
  }
  std::string text;
  text.reserve(sizeof(WireHead) + head.vertex_bytes + head.index_bytes + 4 * ids.size() + 8);
  append_raw(text, head);
  append_padded(text, vertex_bytes, head.vertex_bytes);
  append_padded(text, index_bytes, head.index_bytes);
  for (std::size_t i = 0; i < head.id_count; ++i) append_raw(text, number(ids[i]));
  return text;
}

std::string join_chunks(std::span<const std::shared_ptr<const std::string>> chunks) {
  std::string text = "PFC2";
  append_raw(text, static_cast<std::uint32_t>(chunks.size()));
  for (const auto& chunk : chunks) text += *chunk;
  return text;
}

std::shared_ptr<const std::string> ChunkCache::encoded(const SnapshotSurface& surface, std::size_t chunk) {
  const std::uint64_t block = pack(surface.snapshot().chunks[chunk].index);
  const std::uint64_t version = surface.version(chunk);
  const std::lock_guard lock(mutex_);
  const auto found = entry_of_.find(block);
  if (found != entry_of_.end() && found->second->version == version) {
    entries_.splice(entries_.begin(), entries_, found->second);
    return entries_.front().bytes;
  }
  if (found != entry_of_.end()) drop(found->second);
  auto bytes = std::make_shared<const std::string>(encode_chunk(surface, chunk, block_size_m_));
  ++encodings_;
  entries_.push_front({block, version, bytes});
  entry_of_[block] = entries_.begin();
  bytes_ += bytes->size();
  while (bytes_ > max_bytes_) drop(std::prev(entries_.end()));
  return bytes;
}

void ChunkCache::drop(std::list<Entry>::iterator entry) {
  bytes_ -= entry->bytes->size();
  entry_of_.erase(entry->block);
  entries_.erase(entry);
}

void ChunkCache::clear() {
  const std::lock_guard lock(mutex_);
  entries_.clear();
  entry_of_.clear();
  bytes_ = 0;
}

std::size_t ChunkCache::bytes() const {
  const std::lock_guard lock(mutex_);
  return bytes_;
}

std::uint64_t ChunkCache::encodings() const {
  const std::lock_guard lock(mutex_);
  return encodings_;
}

}  // namespace panoptic
