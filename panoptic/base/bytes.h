// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Numbers as bytes, lowest first, on any machine.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

namespace panoptic {

template <typename Number>
void append_number(std::vector<std::uint8_t>& bytes, Number number) {
  if constexpr (std::is_same_v<Number, float>) {
    append_number(bytes, std::bit_cast<std::uint32_t>(number));
  } else {
    static_assert(std::is_unsigned_v<Number>);
    for (std::size_t k = 0; k < sizeof number; ++k) bytes.push_back(static_cast<std::uint8_t>(number >> (8 * k)));
  }
}

// Takes numbers from the front. Past the end it gives zeros and remembers that.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::uint8_t> bytes) : left_(bytes) {}

  template <typename Number>
  Number take() {
    if constexpr (std::is_same_v<Number, float>) {
      return std::bit_cast<float>(take<std::uint32_t>());
    } else {
      static_assert(std::is_unsigned_v<Number>);
      if (left_.size() < sizeof(Number)) {
        is_short_ = true;
        left_ = {};
        return 0;
      }
      std::uint64_t number = 0;
      for (std::size_t k = 0; k < sizeof(Number); ++k) number |= std::uint64_t{left_[k]} << (8 * k);
      left_ = left_.subspan(sizeof(Number));
      return static_cast<Number>(number);
    }
  }

  void skip(std::size_t count) {
    is_short_ = is_short_ || count > left_.size();
    left_ = left_.subspan(std::min(count, left_.size()));
  }
  std::size_t left() const { return left_.size(); }
  bool is_short() const { return is_short_; }  // more was taken than there was

 private:
  std::span<const std::uint8_t> left_;
  bool is_short_ = false;
};

// Differences of either sign, in numbers without one, as small numbers: 0, -1, 1, -2 ... And back.
template <typename Number>
Number as_small(Number difference) {
  constexpr int kSign = std::numeric_limits<Number>::digits - 1;
  const auto sign = static_cast<Number>(Number{0} - (difference >> kSign));
  return static_cast<Number>(static_cast<Number>(difference << 1) ^ sign);
}
template <typename Number>
Number from_small(Number number) {
  return static_cast<Number>(static_cast<Number>(number >> 1) ^ static_cast<Number>(Number{0} - (number & 1)));
}

}  // namespace panoptic
