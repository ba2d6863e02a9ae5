// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/unpacking.h"

#include <bzlib.h>
#include <gtest/gtest.h>
#include <lz4frame.h>

#include <string>

#include "panoptic/base/compression.h"

namespace panoptic {
namespace {

using Unpack = UnpackedBytes (*)(PackedBytes, std::size_t);

std::vector<std::uint8_t> original(std::size_t size) {
  std::vector<std::uint8_t> bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>((i * i / 7) % 251);
  return bytes;
}

std::vector<std::uint8_t> lz4(const std::vector<std::uint8_t>& bytes) {
  std::vector<std::uint8_t> packed(LZ4F_compressFrameBound(bytes.size(), nullptr));
  packed.resize(LZ4F_compressFrame(packed.data(), packed.size(), bytes.data(), bytes.size(), nullptr));
  return packed;
}

std::vector<std::uint8_t> bzip2(std::vector<std::uint8_t> bytes) {
  auto size = static_cast<unsigned>(bytes.size() + bytes.size() / 50 + 600);
  std::vector<std::uint8_t> packed(size);
  EXPECT_EQ(BZ2_bzBuffToBuffCompress(reinterpret_cast<char*>(packed.data()), &size, reinterpret_cast<char*>(bytes.data()),
                                     static_cast<unsigned>(bytes.size()), 9, 0, 0),
            BZ_OK);
  packed.resize(size);
  return packed;
}

std::vector<std::uint8_t> zstd(const std::vector<std::uint8_t>& bytes) { return Compressor().compress(bytes); }

struct Codec {
  const char* name;
  Unpack unpack;
  std::vector<std::uint8_t> (*pack)(const std::vector<std::uint8_t>&);
};
const Codec kCodecs[] = {{"lz4", unpacked_lz4, lz4},
                         {"bzip2", unpacked_bzip2, [](const std::vector<std::uint8_t>& b) { return bzip2(b); }},
                         {"zstd", unpacked_zstd, zstd}};

TEST(Unpacking, GivesBackWhatWasPacked) {
  for (const Codec& codec : kCodecs) {
    for (const std::size_t size : {std::size_t{1}, std::size_t{100}, std::size_t{300'000}}) {
      const auto bytes = original(size);
      EXPECT_EQ(codec.unpack(codec.pack(bytes), size), bytes) << codec.name << ' ' << size;
    }
    const std::vector<std::uint8_t> zeros(5'000'000);  // far more than the first guess of memory
    EXPECT_EQ(codec.unpack(codec.pack(zeros), zeros.size()), zeros) << codec.name;
  }
}

TEST(Unpacking, RefusesAnotherSizeThanWasClaimed) {
  const auto bytes = original(100'000);
  for (const Codec& codec : kCodecs) {
    const auto packed = codec.pack(bytes);
    EXPECT_FALSE(codec.unpack(packed, bytes.size() - 1)) << codec.name;
    EXPECT_FALSE(codec.unpack(packed, bytes.size() + 1)) << codec.name;
    EXPECT_FALSE(codec.unpack(packed, std::size_t{1} << 40)) << codec.name << ": a terabyte that is not there";
  }
}

TEST(Unpacking, RefusesWhatIsCutOffOrDamaged) {
  const auto bytes = original(100'000);
  for (const Codec& codec : kCodecs) {
    const auto packed = codec.pack(bytes);
    for (const std::size_t left : {std::size_t{0}, std::size_t{3}, packed.size() / 2, packed.size() - 1}) {
      EXPECT_FALSE(codec.unpack(PackedBytes(packed).first(left), bytes.size())) << codec.name << ' ' << left;
    }
    EXPECT_FALSE(codec.unpack(original(1000), 1000)) << codec.name;
  }
}

}  // namespace
}  // namespace panoptic
