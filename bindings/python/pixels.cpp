// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "bindings/python/pixels.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

namespace panoptic::python {
namespace {

// Meanings that were asked for before, each in the one place that its number has. 0 means 0, and no other number is in the place
// of 0 before it was asked for.
class Remembered {
 public:
  explicit Remembered(const Meaning& meaning) : meaning_(meaning) {}

  std::uint16_t of(std::int64_t number) {
    Entry& entry = entries_[static_cast<std::uint64_t>(number) % kPlaces];
    if (entry.number != number) entry = {number, number == 0 ? std::uint16_t{0} : meaning_(number)};
    return entry.meaning;
  }

 private:
  static constexpr std::size_t kPlaces = 1024;
  struct Entry {
    std::int64_t number = 0;
    std::uint16_t meaning = 0;
  };

  const Meaning& meaning_;
  std::array<Entry, kPlaces> entries_{};
};

// A row of numbers of one type, copied so that every number is read once.
template <typename Number>
void copy_row(const WholeNumbers& numbers, int v, std::vector<Number>& row) {
  const char* from = numbers.first + v * numbers.row_bytes;
  if (numbers.pixel_bytes == std::ptrdiff_t{sizeof(Number)}) {
    std::memcpy(row.data(), from, row.size() * sizeof(Number));
    return;
  }
  for (Number& number : row) {
    std::memcpy(&number, from, sizeof(Number));  // wherever it lies
    from += numbers.pixel_bytes;
  }
}

// Neighbours are mostly equal, so that numbers are compared by the chunk with the one before, and few are looked up.
template <typename Number, typename T>
void translate_row(const std::vector<Number>& row, Remembered& meanings, T* to) {
  constexpr std::size_t kChunk = 16;
  Number last = 0;
  T meaning{};
  const std::size_t chunks = row.size() / kChunk;
  for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
    const Number* from = row.data() + chunk * kChunk;
    Number differing = 0;
    for (std::size_t i = 0; i < kChunk; ++i) differing = static_cast<Number>(differing | (from[i] ^ last));
    if (differing == 0) {
      std::fill_n(to + chunk * kChunk, kChunk, meaning);
      continue;
    }
    for (std::size_t i = 0; i < kChunk; ++i) {
      meaning = static_cast<T>(meanings.of(static_cast<std::int64_t>(from[i])));
      to[chunk * kChunk + i] = meaning;
    }
    last = from[kChunk - 1];
  }
  for (std::size_t u = chunks * kChunk; u < row.size(); ++u) {
    to[u] = static_cast<T>(meanings.of(static_cast<std::int64_t>(row[u])));
  }
}

template <typename Number, typename T>
Image<T> translated_of(const WholeNumbers& numbers, const Meaning& meaning) {
  Image<T> image(numbers.width, numbers.height);
  Remembered meanings(meaning);
  std::vector<Number> row(static_cast<std::size_t>(numbers.width));
  for (int v = 0; v < numbers.height; ++v) {
    copy_row(numbers, v, row);
    translate_row(row, meanings, image.row(v));
  }
  return image;
}

bool is_blank(const std::uint8_t* row, int width) {
  unsigned any = 0;
  for (int u = 0; u < width; ++u) any |= row[u];
  return any == 0;
}

}  // namespace

template <typename T>
Image<T> translated(const WholeNumbers& numbers, const Meaning& meaning) {
  switch (numbers.bytes) {
    case 1:
      return numbers.is_signed ? translated_of<std::int8_t, T>(numbers, meaning)
                               : translated_of<std::uint8_t, T>(numbers, meaning);
    case 2:
      return numbers.is_signed ? translated_of<std::int16_t, T>(numbers, meaning)
                               : translated_of<std::uint16_t, T>(numbers, meaning);
    case 4:
      return numbers.is_signed ? translated_of<std::int32_t, T>(numbers, meaning)
                               : translated_of<std::uint32_t, T>(numbers, meaning);
    default:
      return numbers.is_signed ? translated_of<std::int64_t, T>(numbers, meaning)
                               : translated_of<std::uint64_t, T>(numbers, meaning);
  }
}
template Image<std::uint16_t> translated(const WholeNumbers& numbers, const Meaning& meaning);
template Image<ClassId> translated(const WholeNumbers& numbers, const Meaning& meaning);

Instance cut_out(const ImageView<std::uint8_t>& mask) {
  const int width = mask.width();
  int u0 = width, v0 = mask.height(), u1 = 0, v1 = 0;
  for (int v = 0; v < mask.height(); ++v) {
    const std::uint8_t* row = mask.row(v);
    if (is_blank(row, width)) continue;
    int begin = 0;
    while (begin < u0 && row[begin] == 0) ++begin;
    int end = width;
    while (end > u1 && row[end - 1] == 0) --end;
    u0 = std::min(u0, begin);
    u1 = std::max(u1, end);
    v0 = std::min(v0, v);
    v1 = v + 1;
  }
  if (u0 >= u1) return {};
  Instance instance{{}, u0, v0, Image<std::uint8_t>(u1 - u0, v1 - v0)};
  for (int v = v0; v < v1; ++v) std::copy_n(mask.row(v) + u0, u1 - u0, instance.mask.row(v - v0));
  return instance;
}

void paint(const Instance& instance, Image<ClassId>& semantic) {
  const ClassId painted = instance.segment.class_id;
  for (int v = 0; v < instance.mask.height(); ++v) {
    const std::uint8_t* mask = instance.mask.row(v);
    ClassId* pixels = semantic.row(instance.y0 + v) + instance.x0;
    for (int u = 0; u < instance.mask.width(); ++u) {
      const bool is_free = mask[u] != 0 && pixels[u] == ClassId::kUnknown;
      pixels[u] = is_free ? painted : pixels[u];
    }
  }
}

Image<float> in_metres(const ImageView<std::uint16_t>& raw, float metres_per_unit) {
  Image<float> depth(raw.width(), raw.height());
  for (int v = 0; v < raw.height(); ++v) {
    std::transform(raw.row(v), raw.row(v) + raw.width(), depth.row(v),
                   [&](std::uint16_t value) { return static_cast<float>(value) * metres_per_unit; });
  }
  return depth;
}

}  // namespace panoptic::python
