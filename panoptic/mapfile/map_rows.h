// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Shared by writing and reading a map file: names in the table `meta`, checksums of rows.
#pragma once

#include <bit>
#include <cstdint>
#include <initializer_list>

#include "panoptic/base/compression.h"

namespace panoptic {

// Names in `meta` that belong to the format.
inline constexpr const char* kMetaUnits = "units";
inline constexpr const char* kMetaMap = "map";  // MapOptions as TOML
inline constexpr const char* kMetaLabelSet = "label_set";
inline constexpr const char* kMetaEpoch = "epoch";
inline constexpr const char* kMetaIdsGiven = "ids_given";
inline constexpr const char* kMetaSlotsGiven = "slots_given";  // format 1: as many as ids
inline constexpr const char* kMetaRefused = "objects_refused";
inline constexpr const char* kMetaCreated = "created_since_retirement";
inline constexpr const char* kMetaFreeSpace = "free_space";  // its last view; formats 1 and 2 have none
inline constexpr const char* kFormatNames[] = {kMetaUnits,      kMetaMap,     kMetaLabelSet, kMetaEpoch,    kMetaIdsGiven,
                                               kMetaSlotsGiven, kMetaRefused, kMetaCreated,  kMetaFreeSpace};

// The checksum over the integers of a row, each as 8 bytes, lowest first, and then its bytes; as SQLite stores it.
inline std::int64_t row_checksum(std::initializer_list<std::int64_t> integers, std::span<const std::uint8_t> bytes) {
  std::uint64_t sum = kEmptyChecksum;
  for (const std::int64_t integer : integers) {
    std::uint8_t little[8];
    for (int k = 0; k < 8; ++k) little[k] = static_cast<std::uint8_t>(static_cast<std::uint64_t>(integer) >> (8 * k));
    sum = checksum(little, sum);
  }
  return std::bit_cast<std::int64_t>(checksum(bytes, sum));
}

}  // namespace panoptic
