// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Gathers small values into pieces of a fixed size, so that a file can be larger than what memory should hold of it.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

namespace panoptic {

class PieceWriter {
 public:
  using Take = std::function<void(std::string_view)>;

  // `take` is given the pieces, in order. May throw, and so may then every function here.
  explicit PieceWriter(Take take) : take_(std::move(take)) { piece_.reserve(kPieceBytes); }

  // The bytes of a value as they lie in memory.
  template <typename T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    put_bytes({reinterpret_cast<const char*>(&value), sizeof(T)});
  }
  void put_bytes(std::string_view bytes) {
    if (piece_.size() + bytes.size() > kPieceBytes) finish();
    if (bytes.size() > kPieceBytes) {
      take_(bytes);
    } else {
      piece_.append(bytes);
    }
  }
  // Hands on what is left.
  void finish() {
    if (!piece_.empty()) take_(piece_);
    piece_.clear();
  }

 private:
  static constexpr std::size_t kPieceBytes = std::size_t{256} << 10;

  Take take_;
  std::string piece_;
};

}  // namespace panoptic
