// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/benchmark/chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "panoptic/error.h"
#include "panoptic/io/draw_text.h"

namespace panoptic {
namespace {

constexpr int kWidth_px = 960;
constexpr int kHeight_px = 480;
constexpr int kLeft_px = 70;
constexpr int kRight_px = 930;
constexpr int kTop_px = 70;
constexpr int kBottom_px = 400;
constexpr double kText = 0.45;
constexpr double kTitle = 0.6;
constexpr int kTicks = 5;
constexpr double kGroupShare = 0.8;  // of a category's width that its bars fill
constexpr Rgb kInk{40, 40, 40};
constexpr Rgb kGrid{220, 220, 220};
constexpr std::array<Rgb, 8> kColors{{{31, 119, 180},
                                      {255, 127, 14},
                                      {44, 160, 44},
                                      {214, 39, 40},
                                      {148, 103, 189},
                                      {140, 86, 75},
                                      {227, 119, 194},
                                      {127, 127, 127}}};

void line(Image<Rgb>& image, int u0, int v0, int u1, int v1, const Rgb& color) {
  const int steps = std::max({std::abs(u1 - u0), std::abs(v1 - v0), 1});
  for (int i = 0; i <= steps; ++i) {
    const int u = u0 + (u1 - u0) * i / steps;
    const int v = v0 + (v1 - v0) * i / steps;
    fill(image, {u - 1, v - 1, u + 1, v + 1}, color);
  }
}

void centered(Image<Rgb>& image, const std::string& text, int u, int v, double scale) {
  draw_text(image, text, u - text_size(text, scale).width_px / 2, v, kInk, scale);
}

double largest(const Chart& chart) {
  double top = 0;
  for (const Series& series : chart.series) {
    for (const double value : series.values) top = std::isfinite(value) ? std::max(top, value) : top;
  }
  return top;
}

// The smallest of 1, 2, 2.5, 5 times a power of ten, times kTicks, that is not below the value.
double round_step(double value) {
  if (value <= 0) return 1.0 / kTicks;
  const double step = value / kTicks;
  const double power = std::pow(10.0, std::floor(std::log10(step)));
  for (const double factor : {1.0, 2.0, 2.5, 5.0}) {
    if (factor * power >= step * (1 - 1e-9)) return factor * power;
  }
  return 10 * power;
}

int to_v(double value, double top) { return kBottom_px - static_cast<int>(std::lround(value / top * (kBottom_px - kTop_px))); }

double category_width(const Chart& chart) {
  return static_cast<double>(kRight_px - kLeft_px) / static_cast<double>(std::max<std::size_t>(chart.categories.size(), 1));
}

int category_center(const Chart& chart, std::size_t category) {
  return kLeft_px + static_cast<int>((static_cast<double>(category) + 0.5) * category_width(chart));
}

void draw_axes(const Chart& chart, double step, Image<Rgb>& image) {
  for (int tick = 0; tick <= kTicks; ++tick) {
    const int v = to_v(tick * step, kTicks * step);
    fill(image, {kLeft_px, v, kRight_px, v + 1}, tick == 0 ? kInk : kGrid);
    const std::string text = fmt::format("{:.4g}", tick * step);
    draw_text(image, text, kLeft_px - 8 - text_size(text, kText).width_px, v + 5, kInk, kText);
  }
  for (std::size_t i = 0; i < chart.categories.size(); ++i) {
    centered(image, chart.categories[i], category_center(chart, i), kBottom_px + 22, kText);
  }
  centered(image, chart.title, kWidth_px / 2, 26, kTitle);
  centered(image, chart.x_axis, (kLeft_px + kRight_px) / 2, kBottom_px + 48, kText);
  draw_text(image, chart.y_axis, 8, kTop_px - 14, kInk, kText);
}

void draw_legend(const Chart& chart, Image<Rgb>& image) {
  int u = kLeft_px;
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    fill(image, {u, kHeight_px - 22, u + 12, kHeight_px - 10}, kColors[i % kColors.size()]);
    draw_text(image, chart.series[i].name, u + 18, kHeight_px - 11, kInk, kText);
    u += 40 + text_size(chart.series[i].name, kText).width_px;
  }
}

void draw_bars(const Chart& chart, double top, Image<Rgb>& image) {
  const double bar_px = category_width(chart) * kGroupShare / static_cast<double>(chart.series.size());
  for (std::size_t s = 0; s < chart.series.size(); ++s) {
    for (std::size_t i = 0; i < chart.categories.size(); ++i) {
      const double value = chart.series[s].values[i];
      if (!std::isfinite(value)) continue;
      const double from =
          category_center(chart, i) + (static_cast<double>(s) - static_cast<double>(chart.series.size()) / 2) * bar_px;
      fill(image, {static_cast<int>(from), to_v(value, top), static_cast<int>(from + bar_px) - 1, kBottom_px},
           kColors[s % kColors.size()]);
      if (bar_px >= 30)
        centered(image, fmt::format("{:.3g}", value), static_cast<int>(from + bar_px / 2), to_v(value, top) - 5, kText * 0.85);
    }
  }
}

void draw_lines(const Chart& chart, double top, Image<Rgb>& image) {
  for (std::size_t s = 0; s < chart.series.size(); ++s) {
    const auto& values = chart.series[s].values;
    const Rgb& color = kColors[s % kColors.size()];
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (!std::isfinite(values[i])) continue;
      const int u = category_center(chart, i);
      const int v = to_v(values[i], top);
      fill(image, {u - 4, v - 4, u + 4, v + 4}, color);
      centered(image, fmt::format("{:.3g}", values[i]), u, v - 10, kText * 0.85);
      if (i > 0 && std::isfinite(values[i - 1]))
        line(image, category_center(chart, i - 1), to_v(values[i - 1], top), u, v, color);
    }
  }
}

}  // namespace

Image<Rgb> draw(const Chart& chart) {
  PANOPTIC_ASSERT(std::ranges::all_of(chart.series, [&](const Series& s) { return s.values.size() == chart.categories.size(); }));
  Image<Rgb> image(kWidth_px, kHeight_px, Rgb{255, 255, 255});
  const double step = round_step(largest(chart));
  draw_axes(chart, step, image);
  if (chart.kind == ChartKind::kBars) {
    draw_bars(chart, kTicks * step, image);
  } else {
    draw_lines(chart, kTicks * step, image);
  }
  draw_legend(chart, image);
  return image;
}

}  // namespace panoptic
