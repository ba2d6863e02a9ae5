// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/bags/bag_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "panoptic/base/files.h"
#include "panoptic/base/unpacking.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr std::size_t kMostKept = 8;                                // colour, depth and their neighbours ahead
constexpr std::uint64_t kMostKeptBytes = std::uint64_t{256} << 20;  // beyond the one in use

UnpackedBytes unpacked_bytes(const BagBytes& packed, const BagChunk& chunk) {
  switch (chunk.packing) {
    case ChunkPacking::kBzip2:
      return unpacked_bzip2(packed, chunk.bytes);
    case ChunkPacking::kLz4:
      return unpacked_lz4(packed, chunk.bytes);
    case ChunkPacking::kZstd:
      return unpacked_zstd(packed, chunk.bytes);
    case ChunkPacking::kNone:
      break;
  }
  return std::nullopt;
}

}  // namespace

ChunkPacking packing_of(std::string_view name, const std::string& place) {
  if (name.empty() || name == "none") return ChunkPacking::kNone;
  if (name == "bz2") return ChunkPacking::kBzip2;
  if (name == "lz4") return ChunkPacking::kLz4;
  if (name == "zstd") return ChunkPacking::kZstd;
  throw Error(fmt::format("{}: compression '{}' cannot be read (none, bz2, lz4 and zstd can); record it anew with one of these",
                          place, name));
}

BagFile::BagFile(const std::filesystem::path& path) : name_(path.string()), file_(os::open_to_read(path)) {
  const auto status = file_.status();
  if (!status) {
    throw FileError(fmt::format("cannot read {}: {}; check the path and its permissions", name_, os::reason(errno)));
  }
  size_ = status->size;
}

BagBytes BagFile::read(std::uint64_t offset, std::uint64_t bytes) const {
  if (offset >= size_) return {};
  BagBytes result(std::min(bytes, size_ - offset));
  const auto got = file_.read(offset, result.data(), result.size());
  if (!got) throw FileError(fmt::format("cannot read {}: {}; check the disk", name_, os::reason(errno)));
  result.resize(*got);
  return result;
}

BagFile::SharedBytes BagFile::unpacked(const BagChunk& chunk) const {
  {
    const std::scoped_lock lock(mutex_);
    const auto found = std::find_if(kept_.begin(), kept_.end(), [&](const Kept& k) { return k.offset == chunk.offset; });
    if (found != kept_.end()) {
      kept_.splice(kept_.begin(), kept_, found);
      return found->bytes;
    }
  }
  if (chunk.bytes > kMostChunkBytes || chunk.packed_bytes > kMostChunkBytes) return nullptr;
  BagBytes packed = read(chunk.offset, chunk.packed_bytes);
  if (packed.size() != chunk.packed_bytes) return nullptr;
  UnpackedBytes bytes = chunk.packing == ChunkPacking::kNone ? UnpackedBytes(std::move(packed)) : unpacked_bytes(packed, chunk);
  if (!bytes) return nullptr;
  auto shared = std::make_shared<const BagBytes>(std::move(*bytes));
  const std::scoped_lock lock(mutex_);
  kept_.push_front({chunk.offset, shared});
  const auto kept_bytes = [&] {
    std::uint64_t sum = 0;
    for (const Kept& k : kept_) sum += k.bytes->size();
    return sum;
  };
  while (kept_.size() > kMostKept || (kept_.size() > 1 && kept_bytes() > kMostKeptBytes)) kept_.pop_back();
  return shared;
}

}  // namespace panoptic
