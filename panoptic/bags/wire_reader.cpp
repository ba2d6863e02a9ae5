// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/bags/wire_reader.h"

#include <fmt/format.h>

namespace panoptic {

WireReader::WireReader(std::span<const std::uint8_t> bytes, std::string_view serialization)
    : left_(bytes), is_ros1_(serialization == "ros1") {
  constexpr std::size_t kEncapsulationBytes = 4;
  constexpr int kPlainBigEndian = 0;
  constexpr int kPlainLittleEndian = 1;
  if (is_ros1_) return;
  if (serialization != "cdr")
    throw MessageError(fmt::format("messages serialized as '{}' cannot be read (ros1 and cdr can)", serialization));
  const auto head = take_raw(kEncapsulationBytes);
  const int kind = head[0] * 256 + head[1];
  if (kind != kPlainBigEndian && kind != kPlainLittleEndian)
    throw MessageError(fmt::format("CDR of kind {} cannot be read (plain CDR, 0 and 1, can)", kind));
  is_big_endian_ = kind == kPlainBigEndian;
  taken_ = 0;
}

std::string_view WireReader::take_text() {
  auto bytes = take_bytes();
  if (!is_ros1_ && !bytes.empty() && bytes.back() == 0) bytes = bytes.first(bytes.size() - 1);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::span<const std::uint8_t> WireReader::take_bytes() { return take_raw(take_count(1)); }

std::vector<double> WireReader::take_doubles() {
  std::vector<double> numbers(take_count(sizeof(double)));
  for (double& number : numbers) number = take<double>();
  return numbers;
}

std::uint32_t WireReader::take_count(std::size_t least) {
  const auto count = take<std::uint32_t>();
  if (count > left_.size() / least) throw MessageError("the message is cut off, or claims more than it holds");
  return count;
}

void WireReader::skip_doubles(std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) take<double>();
}

std::int64_t WireReader::take_time_ns() {
  constexpr std::int64_t kSecond_ns = 1'000'000'000;
  const std::int64_t seconds = is_ros1_ ? std::int64_t{take<std::uint32_t>()} : std::int64_t{take<std::int32_t>()};
  return seconds * kSecond_ns + take<std::uint32_t>();
}

void WireReader::align(std::size_t bytes) {
  if (!is_ros1_) take_raw((bytes - taken_ % bytes) % bytes);
}

std::span<const std::uint8_t> WireReader::take_raw(std::size_t bytes) {
  if (bytes > left_.size()) throw MessageError("the message is cut off, or claims more than it holds");
  const auto taken = left_.first(bytes);
  left_ = left_.subspan(bytes);
  taken_ += bytes;
  return taken;
}

}  // namespace panoptic
