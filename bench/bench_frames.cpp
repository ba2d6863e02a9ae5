// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/bench_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <optional>
#include <utility>

#include "panoptic/base/json.h"
#include "panoptic/error.h"
#include "panoptic/parallel.h"
#include "panoptic/predictor.h"
#include "panoptic/simulation.h"

namespace panoptic {
namespace {

constexpr const char* kSeededLabelSet = "indoor";

std::size_t image_bytes(const BenchFrame& f) {
  return (f.frame.depth.size() + f.frame.depth_weight.size()) * sizeof(float) + f.frame.color.size() * sizeof(Rgb) +
         f.segmentation.segment_at.size() * sizeof(std::uint16_t);
}

template <typename T>
Image<T> resized(const ImageView<T>& image, double factor) {
  const auto edge = [factor](int px) { return std::max(1, static_cast<int>(std::lround(px * factor))); };
  Image<T> result(edge(image.width()), edge(image.height()));
  for (int v = 0; v < result.height(); ++v) {
    const int from_v = std::min(static_cast<int>((v + 0.5) / factor), image.height() - 1);
    for (int u = 0; u < result.width(); ++u) {
      result(u, v) = image(std::min(static_cast<int>((u + 0.5) / factor), image.width() - 1), from_v);
    }
  }
  return result;
}

Camera resized(const Camera& c, double factor, int width, int height) {
  return {width, height, c.fx * factor, c.fy * factor, (c.cx + 0.5) * factor - 0.5, (c.cy + 0.5) * factor - 0.5};
}

// Nearest pixels: no depths are made up between surfaces.
Frame resized(const Frame& frame, double factor) {
  Frame result = frame;
  result.depth = resized(frame.depth, factor);
  if (!frame.depth_weight.empty()) result.depth_weight = resized(frame.depth_weight, factor);
  result.color = resized(frame.color, factor);
  result.depth_camera = resized(frame.depth_camera, factor, result.depth.width(), result.depth.height());
  result.color_camera = resized(frame.color_camera, factor, result.color.width(), result.color.height());
  return result;
}

std::optional<Frame> next_usable(FrameStream& stream, double factor) {
  while (std::optional<ReadResult> read = stream.next()) {
    if (read->frame && check(*read->frame).used) return factor == 1 ? std::move(read->frame) : resized(*read->frame, factor);
  }
  return std::nullopt;
}

Json to_json(const Camera& c) {
  return {{"width", c.width}, {"height", c.height}, {"fx", c.fx}, {"fy", c.fy}, {"cx", c.cx}, {"cy", c.cy}};
}

}  // namespace

void write_raw_frames(const std::filesystem::path& folder, const BenchFrames& recording) {
  std::filesystem::create_directories(folder);
  std::ofstream depth(folder / "depth.u16", std::ios::binary);
  std::ofstream color(folder / "color.rgb", std::ios::binary);
  Json poses = Json::array();
  for (const BenchFrame& f : recording.frames) {
    std::vector<std::uint16_t> millimetres;
    const Image<float> metres = f.frame.depth.copied();
    for (const float z : metres.pixels()) {
      millimetres.push_back(z > 0 && z < 65 ? static_cast<std::uint16_t>(std::lround(z * 1000.0F)) : std::uint16_t{0});
    }
    depth.write(reinterpret_cast<const char*>(millimetres.data()), static_cast<std::streamsize>(millimetres.size() * 2));
    const Image<Rgb> colors = f.frame.color.copied();
    color.write(reinterpret_cast<const char*>(colors.data()), static_cast<std::streamsize>(colors.size() * 3));
    const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> pose = f.frame.world_from_camera.matrix();
    poses.push_back(std::vector<double>(pose.data(), pose.data() + pose.size()));
  }
  if (!depth.flush() || !color.flush())
    throw Error(fmt::format("{}: the frames cannot be written; is the disk full?", folder.string()));
  const Frame& first = recording.frames.front().frame;
  write_json_file(folder / "frames.json", {{"depth_camera", to_json(first.depth_camera)},
                                           {"color_camera", to_json(first.color_camera)},
                                           {"world_from_camera", std::move(poses)}});
}

std::unique_ptr<Predictor> predictor_of(const BenchSource& source, const Dataset& dataset) {
  Options options;
  options.predictions = source.predictions.string();
  return make_predictor(options, dataset);
}

LabelSet labels_of(const Predictor* predictor) {
  return predictor != nullptr ? predictor->labels() : load_label_set(kSeededLabelSet);
}

BenchFrames load_bench_frames(const BenchSource& source) {
  const auto dataset = open_dataset(source.recording, source.calibration);
  const auto predictor = predictor_of(source, *dataset);
  BenchFrames result{dataset->description(), labels_of(predictor.get()), {}, 0};
  FrameStream stream(*dataset, source.range);
  while (std::optional<Frame> frame = next_usable(stream, source.resize)) {
    BenchFrame& f = result.frames.emplace_back();
    f.frame = std::move(*frame);
    if (predictor) f.segmentation = predictor->predict(f.frame);
  }
  if (result.frames.empty()) throw Error(fmt::format("{}: no frame is usable; panoptic doctor says why", source.recording));
  if (!predictor) {
    parallel_for(result.frames.size(), [&](std::size_t i) {
      BenchFrame& f = result.frames[i];
      f.segmentation = seeded_labels(f.frame, result.labels, source.seeded);
    });
  }
  for (const BenchFrame& f : result.frames) result.bytes += image_bytes(f);
  return result;
}

NextFrame again_and_again(const BenchFrames& recording) {
  const std::int64_t numbers = recording.frames.back().frame.index + 1;
  const double lasts_s = recording.frames.back().frame.time_s - recording.frames.front().frame.time_s + 1.0 / 30;
  return [&recording, numbers, lasts_s, given = std::size_t{0}]() mutable -> std::optional<BenchFrame> {
    const std::size_t lap = given / recording.frames.size();
    BenchFrame next = recording.frames[given++ % recording.frames.size()];
    next.frame.index += static_cast<std::int64_t>(lap) * numbers;
    next.frame.time_s += static_cast<double>(lap) * lasts_s;
    return next;
  };
}

NextFrame streamed(const BenchSource& source, const Dataset& dataset, Predictor* predictor) {
  const auto stream = std::make_shared<FrameStream>(dataset, source.range);
  const LabelSet labels = labels_of(predictor);
  return [=, &source]() -> std::optional<BenchFrame> {
    std::optional<Frame> frame = next_usable(*stream, source.resize);
    if (!frame) return std::nullopt;
    Segmentation seen = predictor != nullptr ? predictor->predict(*frame) : seeded_labels(*frame, labels, source.seeded);
    return BenchFrame{std::move(*frame), std::move(seen)};
  };
}

}  // namespace panoptic
