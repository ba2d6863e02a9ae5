// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/rasterizer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "panoptic/data/speaker.h"
#include "panoptic/mesh.h"
#include "panoptic/parallel.h"

namespace panoptic {
namespace {

constexpr int kSamples = 2;       // per pixel and direction
constexpr int kSubsteps = 16;     // sample positions are exact to 1/16 sample, so that neighbours share edges without gaps
constexpr int kBandRows_px = 32;  // one task
constexpr int kMargin = 2;        // sample rows beyond a band that its lines look at
constexpr float kMaxBeyond_px = 16000;
constexpr std::size_t kTrianglesPerTask = 16384;

struct Sample {
  float inverse_z = 0;  // 0: background
  Rgb color;
  std::uint32_t label = 0;
};

using Point = std::array<std::int64_t, 2>;  // in substeps; sample i has its centre at (i + 1/2) * kSubsteps

std::int64_t to_substeps(float px) { return std::llround((static_cast<double>(px) + 0.5) * kSamples * kSubsteps); }

Point to_point(const DrawnVertex& vertex) { return {to_substeps(vertex.at.x()), to_substeps(vertex.at.y())}; }

// Twice the area of (a, b, p); positive where p lies clockwise of a -> b on the screen, whose v points down.
std::int64_t edge(const Point& a, const Point& b, const Point& p) {
  return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
}

// One of two triangles that share an edge gets the samples that lie exactly on it.
bool owns(const Point& a, const Point& b) { return a[1] == b[1] ? b[0] > a[0] : b[1] < a[1]; }

std::int64_t floor_div(std::int64_t value, std::int64_t by) { return value >= 0 ? value / by : -((-value + by - 1) / by); }

// The samples whose centres lie in [low, high], in substeps.
std::pair<std::int64_t, std::int64_t> samples_between(std::int64_t low, std::int64_t high) {
  return {floor_div(low - kSubsteps / 2 + kSubsteps - 1, kSubsteps), floor_div(high - kSubsteps / 2, kSubsteps)};
}

struct Corners {
  std::array<const DrawnVertex*, 3> vertex{};  // clockwise: area > 0
  std::array<Point, 3> at{};
  std::int64_t area = 0;
  const DrawnVertex* speaker = nullptr;
};

bool is_in_reach(const Drawing& drawing, const DrawnVertex& v) {
  const auto reach = [](float at, int size) { return at > -kMaxBeyond_px && at < static_cast<float>(size) + kMaxBeyond_px; };
  return v.at.z() > 0 && reach(v.at.x(), drawing.width_px) && reach(v.at.y(), drawing.height_px);
}

// area <= 0 if the triangle is not to be drawn.
Corners corners_of(const Drawing& drawing, std::size_t triangle) {
  const auto& t = (*drawing.triangles)[triangle];
  const std::array<const DrawnVertex*, 3> v = {&drawing.vertices[t[0]], &drawing.vertices[t[1]], &drawing.vertices[t[2]]};
  Corners c;
  if (!std::all_of(v.begin(), v.end(), [&](const DrawnVertex* vertex) { return is_in_reach(drawing, *vertex); })) return c;
  c.vertex = {v[0], v[2], v[1]};
  for (std::size_t i = 0; i < 3; ++i) c.at[i] = to_point(*c.vertex[i]);
  c.area = edge(c.at[0], c.at[1], c.at[2]);
  c.speaker = v[static_cast<std::size_t>(speaker(v[0]->label, v[1]->label, v[2]->label))];
  return c;
}

// The samples of a few picture rows and kMargin sample rows above and below.
class Band {
 public:
  Band(const Drawing& drawing, int first_row_px, int rows_px)
      : flat_(drawing.flat),
        columns_(drawing.width_px * kSamples),
        first_(first_row_px * kSamples - kMargin),
        rows_(rows_px * kSamples + 2 * kMargin),
        samples_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {}

  void draw(const Corners& c) {
    const auto [left, right] = range(c, 0, 0, columns_);
    const auto [top, bottom] = range(c, 1, first_, first_ + rows_);
    std::array<Point, 3> step{};
    std::array<std::int64_t, 3> at_row{};
    const Point start = {left * kSubsteps + kSubsteps / 2, top * kSubsteps + kSubsteps / 2};
    for (std::size_t i = 0; i < 3; ++i) {
      const Point& a = c.at[(i + 1) % 3];
      const Point& b = c.at[(i + 2) % 3];
      step[i] = {-(b[1] - a[1]) * kSubsteps, (b[0] - a[0]) * kSubsteps};
      at_row[i] = edge(a, b, start) - (owns(a, b) ? 0 : 1);
    }
    for (std::int64_t y = top; y < bottom; ++y) {
      std::array<std::int64_t, 3> e = at_row;
      Sample* row = samples_.data() + (y - first_) * columns_;
      for (std::int64_t x = left; x < right; ++x) {
        if ((e[0] | e[1] | e[2]) >= 0) put(c, e, row[x]);
        for (std::size_t i = 0; i < 3; ++i) e[i] += step[i][0];
      }
      for (std::size_t i = 0; i < 3; ++i) at_row[i] += step[i][1];
    }
  }

  // Averages the samples over the background.
  void resolve(int first_row_px, int rows_px, Picture& picture) const {
    constexpr float kHalf = kSamples * kSamples / 2.0F;  // rounds the average
    for (int v = 0; v < rows_px; ++v) {
      const std::array<float, 3> background = background_of(first_row_px + v, picture.color.height());
      for (int u = 0; u < picture.color.width(); ++u) {
        std::array<float, 3> sum = {kHalf, kHalf, kHalf};
        const Sample* front = nullptr;
        for (int k = 0; k < kSamples * kSamples; ++k) {
          const Sample* sample =
              samples_.data() + (v * kSamples + k / kSamples + kMargin) * columns_ + u * kSamples + k % kSamples;
          const bool is_covered = sample->inverse_z > 0;
          const float light = is_covered ? line(*sample, sample - samples_.data()) : 1;
          const std::array<float, 3> rgb = is_covered ? to_floats(sample->color) : background;
          for (std::size_t i = 0; i < 3; ++i) sum[i] += light * rgb[i];
          if (is_covered && front == nullptr) front = sample;
        }
        const auto channel = [&](std::size_t i) { return static_cast<std::uint8_t>(sum[i] / (kSamples * kSamples)); };
        picture.color(u, first_row_px + v) = {channel(0), channel(1), channel(2)};
        picture.label(u, first_row_px + v) = front != nullptr ? front->label : std::uint32_t{0};
        picture.covered(u, first_row_px + v) = front != nullptr ? 1 : 0;
      }
    }
  }

 private:
  static std::array<float, 3> to_floats(const Rgb& c) {
    return {static_cast<float>(c.r), static_cast<float>(c.g), static_cast<float>(c.b)};
  }

  // Light grey, darker below: white paper is seen against it.
  static std::array<float, 3> background_of(int row_px, int height_px) {
    const float down = static_cast<float>(row_px) / static_cast<float>(height_px);
    return {236 - 34 * down, 239 - 32 * down, 243 - 29 * down};
  }

  static std::pair<std::int64_t, std::int64_t> range(const Corners& c, std::size_t axis, std::int64_t begin, std::int64_t end) {
    const auto [low, high] = std::minmax({c.at[0][axis], c.at[1][axis], c.at[2][axis]});
    const auto [first, last] = samples_between(low, high);
    return {std::max(first, begin), std::min(last + 1, end)};
  }

  void put(const Corners& c, const std::array<std::int64_t, 3>& e, Sample& sample) const {
    const float scale = 1.0F / static_cast<float>(c.area);
    const float w1 = static_cast<float>(e[1]) * scale;
    const float w2 = static_cast<float>(e[2]) * scale;
    const auto blend = [&](float a, float b, float d) { return a + w1 * (b - a) + w2 * (d - a); };
    const auto& v = c.vertex;
    const float inverse_z = blend(v[0]->at.z(), v[1]->at.z(), v[2]->at.z());
    if (inverse_z <= sample.inverse_z) return;
    const auto channel = [&](std::uint8_t Rgb::*of) {
      const float color =
          flat_ ? static_cast<float>(c.speaker->color.*of) * blend(v[0]->shade, v[1]->shade, v[2]->shade)
                : blend(static_cast<float>(v[0]->color.*of) * v[0]->shade, static_cast<float>(v[1]->color.*of) * v[1]->shade,
                        static_cast<float>(v[2]->color.*of) * v[2]->shade);
      return static_cast<std::uint8_t>(std::clamp(color, 0.0F, 255.0F));
    };
    sample = {inverse_z, {channel(&Rgb::r), channel(&Rgb::g), channel(&Rgb::b)}, c.speaker->label};
  }

  // How much light a sample keeps. On a plane 1 / z is linear on the screen, so its second difference is where surfaces meet or
  // hide each other.
  float line(const Sample& sample, std::ptrdiff_t at) const {
    constexpr float kStrength = 12;
    constexpr float kDarkest = 0.45F;
    constexpr float kBorder = 0.72F;
    const std::ptrdiff_t column = at % columns_;
    if (column < kMargin || column >= columns_ - kMargin) return 1;
    float crease = 0;
    bool is_border = false;
    for (const std::ptrdiff_t step : {std::ptrdiff_t{1}, std::ptrdiff_t{columns_}}) {
      const Sample& before = samples_[static_cast<std::size_t>(at - kMargin * step)];
      const Sample& after = samples_[static_cast<std::size_t>(at + kMargin * step)];
      crease += std::max(0.0F, before.inverse_z + after.inverse_z - 2 * sample.inverse_z) / sample.inverse_z;
      const Sample& next = samples_[static_cast<std::size_t>(at + step)];
      is_border = is_border || (next.inverse_z > 0 && next.label != sample.label);
    }
    return std::max(kDarkest, 1 - kStrength * crease) * (flat_ && is_border ? kBorder : 1.0F);
  }

  bool flat_;
  std::int64_t columns_;
  std::int64_t first_;  // sample row of the picture
  std::int64_t rows_;
  std::vector<Sample> samples_;
};

using Lists = std::vector<std::vector<std::uint32_t>>;

// Per band the triangles to draw there, in ascending order.
Lists triangles_of_bands(const Drawing& drawing, std::size_t begin, std::size_t end, std::size_t bands) {
  Lists lists(bands);
  constexpr std::int64_t kBandSamples = kBandRows_px * kSamples;
  for (std::size_t triangle = begin; triangle < end; ++triangle) {
    const Corners c = corners_of(drawing, triangle);
    if (c.area <= 0) continue;
    const auto [low, high] = std::minmax({c.at[0][1], c.at[1][1], c.at[2][1]});
    const auto [top, bottom] = samples_between(low, high);
    const auto [left, right] = std::minmax({c.at[0][0], c.at[1][0], c.at[2][0]});
    if (right < 0 || left > static_cast<std::int64_t>(drawing.width_px) * kSamples * kSubsteps) continue;
    const std::int64_t first = std::max(floor_div(top - kMargin, kBandSamples), std::int64_t{0});
    const std::int64_t last = std::min(floor_div(bottom + kMargin, kBandSamples), static_cast<std::int64_t>(bands) - 1);
    for (std::int64_t band = first; band <= last; ++band)
      lists[static_cast<std::size_t>(band)].push_back(static_cast<std::uint32_t>(triangle));
  }
  return lists;
}

}  // namespace

Picture rasterize(const Drawing& drawing) {
  const int width = drawing.width_px;
  const int height = drawing.height_px;
  Picture picture{Image<Rgb>(width, height), Image<std::uint32_t>(width, height), Image<std::uint8_t>(width, height)};
  const std::size_t count = drawing.triangles->size();
  const auto bands = static_cast<std::size_t>((height + kBandRows_px - 1) / kBandRows_px);
  std::vector<Lists> lists((count + kTrianglesPerTask - 1) / kTrianglesPerTask);
  parallel_for(lists.size(), [&](std::size_t i) {
    lists[i] = triangles_of_bands(drawing, i * kTrianglesPerTask, std::min(count, (i + 1) * kTrianglesPerTask), bands);
  });
  parallel_for(bands, [&](std::size_t i) {
    const int first_row = static_cast<int>(i) * kBandRows_px;
    const int rows = std::min(kBandRows_px, height - first_row);
    Band band(drawing, first_row, rows);
    for (const Lists& part : lists) {
      for (const std::uint32_t triangle : part[i]) band.draw(corners_of(drawing, triangle));
    }
    band.resolve(first_row, rows, picture);
  });
  return picture;
}

}  // namespace panoptic
