// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predict/prediction_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/base/json.h"
#include "panoptic/base/json_value.h"
#include "panoptic/data/label_json.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr const char* kIndexFile = "predictions.json";
constexpr const char* kFormat = "panoptic predictions";
constexpr int kVersion = 1;
constexpr int kMaxSide_px = 16384;
constexpr int kMaxClassId = 999;
constexpr std::size_t kMaxSegments = 65535;  // the PNG has 16 bits

std::filesystem::path frame_file(const std::filesystem::path& folder, std::int64_t index, std::string_view extension) {
  return folder / fmt::format("{:06}.{}", index, extension);
}

Json to_json(const LabelSet& labels) {
  Json classes = classes_json(labels);
  for (std::size_t i = 0; i < classes.size(); ++i) {
    const LabelClass& c = labels.classes()[i];
    if (c.max_size_m > 0) classes[i]["max_size_m"] = c.max_size_m;
    if (c.is_support) classes[i]["is_support"] = true;
    if (c.is_mobile) classes[i]["is_mobile"] = true;
  }
  return {{"name", labels.name()}, {"classes", std::move(classes)}};
}

LabelSet to_labels(const JsonValue& json) {
  const JsonValue classes = json.at("classes");
  return label_set_of(json.at("name").text(), classes_in(classes), classes);
}

Json to_json(const Segment& segment, const LabelSet& labels) {
  Json probabilities = Json::array();
  for (const ClassProbability& p : segment.class_probabilities) {
    probabilities.push_back({{"class_id", number(p.class_id)}, {"probability", p.probability}});
  }
  Json json = {{"class_id", number(segment.class_id)},
               {"class", labels.name_of(segment.class_id)},
               {"score", segment.score},
               {"class_probabilities", std::move(probabilities)}};
  if (segment.is_whole_class) json["is_whole_class"] = true;
  return json;
}

ClassId to_class(const JsonValue& json, const LabelSet& labels) {
  const auto id = static_cast<ClassId>(json.integer(1, kMaxClassId));
  if (labels.find(id) == nullptr) json.wrong(fmt::format("a class of the label set '{}'", labels.name()));
  return id;
}

Segment to_segment(const JsonValue& json, const LabelSet& labels) {
  Segment segment;
  segment.class_id = to_class(json.at("class_id"), labels);
  segment.score = static_cast<float>(json.at("score").number(0, 1));
  for (const JsonValue& entry : json.at("class_probabilities").elements()) {
    const ClassProbability p{to_class(entry.at("class_id"), labels), static_cast<float>(entry.at("probability").number(0, 1))};
    auto& all = segment.class_probabilities;
    if (!all.empty() && p.class_id <= all.back().class_id) entry.at("class_id").wrong("above the one before it");
    all.push_back(p);
  }
  if (const auto whole = json.find("is_whole_class")) segment.is_whole_class = whole->boolean();
  return segment;
}

bool is_share(float value) { return value >= 0 && value <= 1; }

// Nothing, or why the reader would refuse it.
std::string why_unwritable(const Segmentation& segmentation, const LabelSet& labels) {
  const Outcome outcome = check(segmentation, segmentation.segment_at.width(), segmentation.segment_at.height());
  if (!outcome.used) return outcome.reason;
  if (segmentation.segments.size() > kMaxSegments) return fmt::format("more than {} segments", kMaxSegments);
  for (const Segment& segment : segmentation.segments) {
    if (labels.find(segment.class_id) == nullptr)
      return fmt::format("class {} is not in the label set", number(segment.class_id));
    if (!is_share(segment.score)) return fmt::format("score {} is not within 0..1", segment.score);
    ClassId before = ClassId::kUnknown;
    for (const ClassProbability& p : segment.class_probabilities) {
      if (labels.find(p.class_id) == nullptr || p.class_id <= before || !is_share(p.probability)) {
        return "class probabilities must be within 0..1, of classes of the label set, sorted by class";
      }
      before = p.class_id;
    }
  }
  return "";
}

}  // namespace

PredictionWriter::PredictionWriter(std::filesystem::path folder, LabelSet labels, std::string producer)
    : folder_(std::move(folder)), labels_(std::move(labels)), producer_(std::move(producer)) {
  require_writable_folder(folder_);
  if (is_there(folder_ / kIndexFile)) {
    throw Error(fmt::format("{} already holds predictions: choose another folder or remove it", folder_.string()));
  }
}

void PredictionWriter::write(std::int64_t frame_index, const Segmentation& segmentation) {
  if (segmentation.segment_at.empty()) return;
  const int width = segmentation.segment_at.width();
  const int height = segmentation.segment_at.height();
  std::string why = why_unwritable(segmentation, labels_);
  if (frame_index < 0) why = "frame numbers must not be negative";
  if (width_ != 0 && (width != width_ || height != height_)) why = "its size differs from the first frame's";
  if (std::max(width, height) > kMaxSide_px) why = fmt::format("it is larger than {} pixels", kMaxSide_px);
  if (!why.empty())
    throw Error(fmt::format("cannot write the prediction of frame {} to {}: {}", frame_index, folder_.string(), why));
  if (width_ == 0) {
    width_ = width;
    height_ = height;
    write_json_file(folder_ / kIndexFile, {{"format", kFormat},
                                           {"version", kVersion},
                                           {"producer", producer_},
                                           {"image", {{"width", width}, {"height", height}}},
                                           {"label_set", to_json(labels_)}});
  }
  Json segments = Json::array();
  for (const Segment& segment : segmentation.segments) segments.push_back(to_json(segment, labels_));
  write_png(frame_file(folder_, frame_index, "png"), segmentation.segment_at);
  write_json_file(frame_file(folder_, frame_index, "json"), {{"frame", frame_index}, {"segments", std::move(segments)}});
}

PredictionFolder open_predictions(const std::filesystem::path& folder) {
  const std::string file = (folder / kIndexFile).string();
  const Json json = read_json_file(file);
  const JsonValue root(json, file);
  if (root.at("format").text() != kFormat) root.at("format").wrong(fmt::format("\"{}\"", kFormat));
  if (root.at("version").integer(1, std::numeric_limits<int>::max()) != kVersion) {
    root.at("version").wrong(fmt::format("{}, the only one that this program reads", kVersion));
  }
  const JsonValue image = root.at("image");
  return {folder, to_labels(root.at("label_set")), static_cast<int>(image.at("width").integer(1, kMaxSide_px)),
          static_cast<int>(image.at("height").integer(1, kMaxSide_px))};
}

Segmentation read_prediction(const PredictionFolder& folder, std::int64_t frame_index) {
  const std::filesystem::path json_path = frame_file(folder.path, frame_index, "json");
  if (!is_there(json_path)) return {};
  const Json json = read_json_file(json_path);
  const JsonValue root(json, json_path.string());
  if (root.at("frame").integer(0, std::numeric_limits<std::int64_t>::max()) != frame_index)
    root.at("frame").wrong("the number in the file's name");
  Segmentation segmentation;
  for (const JsonValue& entry : root.at("segments").elements()) segmentation.segments.push_back(to_segment(entry, folder.labels));

  const std::filesystem::path png_path = frame_file(folder.path, frame_index, "png");
  const std::string bytes = read_png_bytes(png_path, folder.width, folder.height);
  segmentation.segment_at = decode_gray16({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, png_path.string());
  const Outcome outcome = check(segmentation, folder.width, folder.height);
  if (!outcome.used) throw Error(fmt::format("{}: {}", png_path.string(), outcome.reason));
  return segmentation;
}

std::string read_png_bytes(const std::filesystem::path& path, int width, int height) {
  constexpr std::uintmax_t kMaxBytes = 256U << 20;
  constexpr std::string_view kSignature("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16);
  constexpr std::size_t kSizesEnd = 24;
  std::string bytes = read_file(path, kMaxBytes);
  if (bytes.size() < kSizesEnd || !bytes.starts_with(kSignature)) throw Error(fmt::format("{}: not a PNG file", path.string()));
  const auto word = [&](std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<std::uint8_t>(bytes[at + i]);
    return value;
  };
  const std::uint32_t actual_width = word(kSignature.size());
  const std::uint32_t actual_height = word(kSignature.size() + 4);
  const auto fits = [](std::uint32_t actual, int expected) {
    return expected > 0 ? actual == static_cast<std::uint32_t>(expected) : actual > 0 && actual <= kMaxSide_px;
  };
  if (!fits(actual_width, width) || !fits(actual_height, height)) {
    const std::string expected =
        width > 0 ? fmt::format("{} x {}", width, height) : fmt::format("at most {} on a side", kMaxSide_px);
    throw Error(
        fmt::format("{}: the image is {} x {} pixels; expected {}", path.string(), actual_width, actual_height, expected));
  }
  return bytes;
}

}  // namespace panoptic
