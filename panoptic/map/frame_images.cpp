// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/map/frame_images.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <iterator>
#include <type_traits>
#include <utility>
#include <vector>

#include "panoptic/base/bytes.h"

namespace panoptic {
namespace {

constexpr int kTransformNumbers = 12;
constexpr std::size_t kHeadBytes = 192;  // cameras, how they lie to each other, the unit, and three sizes
// zstd packs at most 2^15 equal bytes into one, roughly.
constexpr int kMostPacking_log2 = 16;

// Metres per unit as recordings have them: depth that is a whole number of these is kept as that number.
constexpr float kUnits_m[] = {1 / 1000.F, 1 / 5000.F, 1 / 4000.F, 1 / 10000.F, 1 / 6553.5F};

// The median of the pixel before, the one above, and what a plane through the three known ones has.
template <typename Number>
Number foreseen(Number before, Number above, Number before_above) {
  using Wide =
      std::conditional_t<sizeof(Number) == 1, std::int16_t, std::conditional_t<sizeof(Number) == 2, std::int32_t, std::int64_t>>;
  const Wide low = std::min(before, above);
  const Wide high = std::max(before, above);
  return static_cast<Number>(std::clamp(static_cast<Wide>(Wide{before} + Wide{above} - Wide{before_above}), low, high));
}

// Differences of the numbers of a row to what was foreseen.
template <typename Number>
void differences(const Number* now, const Number* above, std::size_t width, Number* to) {
  to[0] = static_cast<Number>(now[0] - above[0]);
  for (std::size_t u = 1; u < width; ++u) to[u] = static_cast<Number>(now[u] - foreseen(now[u - 1], above[u], above[u - 1]));
}

// Numbers as planes of bytes: the lowest byte of all, then the next.
template <typename Number>
Bytes planes_of(const std::vector<Number>& numbers, std::size_t width) {
  Bytes planes(numbers.size() * sizeof(Number));
  std::vector<Number> row(width);
  const std::vector<Number> no_row(width);
  for (std::size_t begin = 0; begin < numbers.size(); begin += width) {
    const Number* now = numbers.data() + begin;
    const Number* above = begin == 0 ? no_row.data() : now - width;
    differences(now, above, width, row.data());
    for (Number& number : row) number = as_small(number);
    for (std::size_t k = 0; k < sizeof(Number); ++k) {
      std::uint8_t* plane = planes.data() + k * numbers.size() + begin;
      for (std::size_t u = 0; u < width; ++u) plane[u] = static_cast<std::uint8_t>(row[u] >> (8 * k));
    }
  }
  return planes;
}

template <typename Number>
std::vector<Number> numbers_of(const Bytes& planes, std::size_t width) {
  std::vector<Number> numbers(planes.size() / sizeof(Number));
  const std::vector<Number> no_row(width);
  for (std::size_t begin = 0; begin < numbers.size(); begin += width) {
    Number* now = numbers.data() + begin;
    const Number* above = begin == 0 ? no_row.data() : now - width;
    for (std::size_t u = 0; u < width; ++u) {
      Number number = 0;
      for (std::size_t k = 0; k < sizeof(Number); ++k) {
        number = static_cast<Number>(number | static_cast<Number>(Number{planes[k * numbers.size() + begin + u]} << (8 * k)));
      }
      const Number guess = u == 0 ? above[0] : foreseen(now[u - 1], above[u], above[u - 1]);
      now[u] = static_cast<Number>(guess + from_small(number));
    }
  }
  return numbers;
}

// A row of a colour image, colour by colour.
struct ColorRow {
  explicit ColorRow(std::size_t width) : red(width), green(width), blue(width) {}
  void take(const Rgb* row) {
    for (std::size_t u = 0; u < red.size(); ++u) {
      red[u] = row[u].r;
      green[u] = row[u].g;
      blue[u] = row[u].b;
    }
  }
  Bytes red, green, blue;
};

// Green as what it differs by from what was foreseen, red and blue as what theirs differs by from that: three planes.
Bytes planes_of(const SharedImage<Rgb>& color) {
  const auto width = static_cast<std::size_t>(color.width());
  Bytes planes(3 * color.size());
  ColorRow now(width);
  ColorRow above(width);
  for (int v = 0; v < color.height(); ++v) {
    now.take(color.row(v));
    std::uint8_t* green = planes.data() + static_cast<std::size_t>(v) * width;
    std::uint8_t* red = green + color.size();
    std::uint8_t* blue = red + color.size();
    differences(now.green.data(), above.green.data(), width, green);
    differences(now.red.data(), above.red.data(), width, red);
    differences(now.blue.data(), above.blue.data(), width, blue);
    for (std::size_t u = 0; u < width; ++u) {
      red[u] = static_cast<std::uint8_t>(red[u] - green[u]);
      blue[u] = static_cast<std::uint8_t>(blue[u] - green[u]);
    }
    std::swap(now, above);
  }
  return planes;
}

Image<Rgb> color_of(const Bytes& planes, int width_px, int height_px) {
  const auto width = static_cast<std::size_t>(width_px);
  Image<Rgb> color(width_px, height_px);
  const std::vector<Rgb> no_row(width);
  for (int v = 0; v < height_px; ++v) {
    Rgb* now = color.row(v);
    const Rgb* above = v == 0 ? no_row.data() : now - width;
    const std::uint8_t* green = planes.data() + static_cast<std::size_t>(v) * width;
    const std::uint8_t* red = green + color.size();
    const std::uint8_t* blue = red + color.size();
    Rgb guess = above[0];
    for (std::size_t u = 0; u < width; ++u) {
      if (u > 0) {
        guess = {foreseen(now[u - 1].r, above[u].r, above[u - 1].r), foreseen(now[u - 1].g, above[u].g, above[u - 1].g),
                 foreseen(now[u - 1].b, above[u].b, above[u - 1].b)};
      }
      now[u] = {static_cast<std::uint8_t>(guess.r + red[u] + green[u]), static_cast<std::uint8_t>(guess.g + green[u]),
                static_cast<std::uint8_t>(guess.b + blue[u] + green[u])};
    }
  }
  return color;
}

// Depth in that unit, if all of it is a whole number of them.
bool in_units(const SharedImage<float>& depth, float unit_m, std::vector<std::uint16_t>& numbers) {
  const float per_m = 1 / unit_m;
  for (int v = 0; v < depth.height(); ++v) {
    const float* row = depth.row(v);
    std::uint16_t* to = numbers.data() + static_cast<std::size_t>(v) * static_cast<std::size_t>(depth.width());
    std::uint32_t lost = 0;  // bits
    for (int u = 0; u < depth.width(); ++u) {
      const float units = std::min(std::max(0.F, row[u] * per_m + 0.5F), 65535.F);  // NaN: 0
      const auto number = static_cast<int>(units);
      to[u] = static_cast<std::uint16_t>(number);
      lost |= std::bit_cast<std::uint32_t>(static_cast<float>(number) * unit_m) ^ std::bit_cast<std::uint32_t>(row[u]);
    }
    if (lost != 0) return false;
  }
  return true;
}

std::vector<std::uint32_t> bits_of(const SharedImage<float>& image) {
  std::vector<std::uint32_t> bits;
  bits.reserve(image.size());
  for (int v = 0; v < image.height(); ++v) {
    std::transform(image.row(v), image.row(v) + image.width(), std::back_inserter(bits),
                   [](float value) { return std::bit_cast<std::uint32_t>(value); });
  }
  return bits;
}

void append_double(Bytes& bytes, double value) { append_number(bytes, std::bit_cast<std::uint64_t>(value)); }
double take_double(ByteReader& reader) { return std::bit_cast<double>(reader.take<std::uint64_t>()); }

void append_camera(Bytes& bytes, const Camera& camera) {
  append_number(bytes, static_cast<std::uint32_t>(camera.width));
  append_number(bytes, static_cast<std::uint32_t>(camera.height));
  for (const double value : {camera.fx, camera.fy, camera.cx, camera.cy}) append_double(bytes, value);
}

std::optional<Camera> take_camera(ByteReader& reader) {
  const auto width = reader.take<std::uint32_t>();
  const auto height = reader.take<std::uint32_t>();
  if (!may_be_image(width, height)) return {};
  Camera camera{static_cast<int>(width), static_cast<int>(height)};
  for (double* value : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) *value = take_double(reader);
  return camera;
}

void append_packed(Bytes& bytes, const Bytes& packed) {
  append_number(bytes, static_cast<std::uint32_t>(packed.size()));
  bytes.insert(bytes.end(), packed.begin(), packed.end());
}

// So many bytes of planes; nothing if they are damaged, or there are none (`absent`: a size of 0).
std::optional<Bytes> take_planes(ByteReader& reader, std::span<const std::uint8_t> bytes, std::size_t size, bool& absent) {
  const auto packed = reader.take<std::uint32_t>();
  absent = packed == 0 && !reader.is_short();
  if (absent || reader.is_short() || packed > reader.left() || size >> kMostPacking_log2 > packed) return std::nullopt;
  Bytes planes(size);
  if (Decompressor().decompress(bytes.subspan(bytes.size() - reader.left(), packed), planes) != size) return std::nullopt;
  reader.skip(packed);
  return planes;
}

Image<float> depth_of(const Bytes& planes, float unit_m, const Camera& camera) {
  const auto width = static_cast<std::size_t>(camera.width);
  Image<float> depth(camera.width, camera.height);
  if (unit_m > 0) {
    const auto numbers = numbers_of<std::uint16_t>(planes, width);
    for (std::size_t i = 0; i < depth.size(); ++i) depth[i] = static_cast<float>(numbers[i]) * unit_m;
  } else {
    const auto numbers = numbers_of<std::uint32_t>(planes, width);
    for (std::size_t i = 0; i < depth.size(); ++i) depth[i] = std::bit_cast<float>(numbers[i]);
  }
  return depth;
}

}  // namespace

bool may_be_image(std::uint32_t width, std::uint32_t height) {
  constexpr std::uint32_t kMostSide_px = 16384;
  constexpr std::uint32_t kMostPixels = 1U << 26;
  return width > 0 && height > 0 && width <= kMostSide_px && height <= kMostSide_px && width <= kMostPixels / height;
}

Bytes pack_images(const Frame& frame) {
  Compressor compressor(Contents::kNoise);
  const auto width = static_cast<std::size_t>(frame.depth.width());
  std::vector<std::uint16_t> numbers(frame.depth.size());
  const auto* const unit = std::ranges::find_if(kUnits_m, [&](float m) { return in_units(frame.depth, m, numbers); });
  const bool has_unit = unit != std::end(kUnits_m);
  const Bytes depth = compressor.compress(has_unit ? planes_of(numbers, width) : planes_of(bits_of(frame.depth), width));
  const bool has_weight = !frame.depth_weight.empty();
  const Bytes weight = has_weight ? compressor.compress(planes_of(bits_of(frame.depth_weight), width)) : Bytes();
  const Bytes color = compressor.compress(planes_of(frame.color));

  Bytes bytes;
  bytes.reserve(kHeadBytes + depth.size() + weight.size() + color.size());
  append_camera(bytes, frame.depth_camera);
  append_camera(bytes, frame.color_camera);
  for (int n = 0; n < kTransformNumbers; ++n) append_double(bytes, frame.color_from_depth.matrix()(n / 4, n % 4));
  append_number(bytes, has_unit ? *unit : 0.F);
  for (const Bytes* packed : {&depth, &weight, &color}) append_packed(bytes, *packed);
  return bytes;
}

std::optional<Frame> unpack_images(std::span<const std::uint8_t> bytes) {
  ByteReader reader(bytes);
  const std::optional<Camera> depth_camera = take_camera(reader);
  const std::optional<Camera> color_camera = take_camera(reader);
  if (!depth_camera || !color_camera) return std::nullopt;
  Frame frame{.depth_camera = *depth_camera, .color_camera = *color_camera};
  for (int n = 0; n < kTransformNumbers; ++n) frame.color_from_depth.matrix()(n / 4, n % 4) = take_double(reader);
  const auto pixels = static_cast<std::size_t>(depth_camera->width) * static_cast<std::size_t>(depth_camera->height);
  const auto unit_m = reader.take<float>();
  if (!(unit_m >= 0 && unit_m <= 1)) return std::nullopt;
  bool absent = false;
  const auto depth = take_planes(reader, bytes, pixels * (unit_m > 0 ? sizeof(std::uint16_t) : sizeof(std::uint32_t)), absent);
  if (!depth) return std::nullopt;
  frame.depth = depth_of(*depth, unit_m, *depth_camera);
  const auto weight = take_planes(reader, bytes, pixels * sizeof(std::uint32_t), absent);
  if (!weight && !absent) return std::nullopt;
  if (weight) frame.depth_weight = depth_of(*weight, 0, *depth_camera);
  const auto of_color = 3 * static_cast<std::size_t>(color_camera->width) * static_cast<std::size_t>(color_camera->height);
  const auto color = take_planes(reader, bytes, of_color, absent);
  if (!color || reader.left() > 0) return std::nullopt;
  frame.color = color_of(*color, color_camera->width, color_camera->height);
  return frame;
}

}  // namespace panoptic
