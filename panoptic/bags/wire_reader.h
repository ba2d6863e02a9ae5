// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The values of a message, one after the other, as ROS 1 or the CDR of ROS 2 has them. Sizes are checked before they are
// believed.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "panoptic/error.h"

namespace panoptic {

// A message that cannot be read; the text says why and names no file.
class MessageError : public Error {
 public:
  using Error::Error;
};

class WireReader {
 public:
  // `serialization` is "ros1" or "cdr". Throws MessageError for another one, and for a CDR of another kind.
  WireReader(std::span<const std::uint8_t> bytes, std::string_view serialization);

  bool is_ros1() const { return is_ros1_; }

  // Throws MessageError past the end, as the others do.
  template <typename Number>
  Number take() {
    align(sizeof(Number));
    std::uint8_t raw[sizeof(Number)];
    std::memcpy(raw, take_raw(sizeof(Number)).data(), sizeof(Number));
    if (is_big_endian_ != (std::endian::native == std::endian::big)) {
      for (std::size_t i = 0; i < sizeof(Number) / 2; ++i) std::swap(raw[i], raw[sizeof(Number) - 1 - i]);
    }
    Number number;
    std::memcpy(&number, raw, sizeof(Number));
    return number;
  }

  std::string_view take_text();                 // without the zero at its end
  std::span<const std::uint8_t> take_bytes();   // a sequence of bytes with its count before it
  std::vector<double> take_doubles();           // a sequence
  std::uint32_t take_count(std::size_t least);  // of a sequence whose elements have at least so many bytes each
  void skip_doubles(std::size_t count);         // of an array
  std::int64_t take_time_ns();                  // stamp: seconds and nanoseconds

 private:
  void align(std::size_t bytes);
  std::span<const std::uint8_t> take_raw(std::size_t bytes);

  std::span<const std::uint8_t> left_;
  std::size_t taken_ = 0;  // since the beginning of what is aligned
  bool is_ros1_ = false;
  bool is_big_endian_ = false;
};

}  // namespace panoptic
