// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/predict/coco_panoptic.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <limits>
#include <set>
#include <span>

#include "panoptic/base/files.h"
#include "panoptic/base/image_header.h"
#include "panoptic/base/image_io.h"
#include "panoptic/base/json_value.h"
#include "panoptic/data/label_json.h"
#include "panoptic/error.h"
#include "panoptic/predict/class_names.h"
#include "panoptic/predict/prediction_io.h"

namespace panoptic {
namespace {

constexpr std::uintmax_t kMaxJsonBytes = 512U << 20;
constexpr std::int64_t kMaxId = std::numeric_limits<std::int64_t>::max();
constexpr std::int64_t kMaxSegmentId = (1 << 24) - 1;
constexpr std::int64_t kMaxClassId = 999;
constexpr std::size_t kMaxSegments = 65535;  // Segmentation counts with 16 bits

// The last run of digits in a file name without its extension.
std::optional<std::int64_t> number_in(const std::string& file_name) {
  constexpr std::size_t kMaxDigits = 18;
  const std::string stem = std::filesystem::path(file_name).stem().string();
  const std::size_t end = stem.find_last_of("0123456789");
  if (end == std::string::npos) return std::nullopt;
  const std::size_t before = stem.find_last_not_of("0123456789", end);
  const std::size_t begin = before == std::string::npos ? 0 : before + 1;
  if (end - begin >= kMaxDigits) return std::nullopt;
  return std::stoll(stem.substr(begin, end - begin + 1));
}

using FrameNumbers = std::map<std::int64_t, std::int64_t>;  // by image id

// The numbers in file names, of which each must have one of its own.
class NumberedNames {
 public:
  void add(std::int64_t image_id, const std::string& file_name) {
    const std::optional<std::int64_t> number = number_in(file_name);
    usable_ = usable_ && number && unique_.insert(*number).second;
    if (usable_) frames_[image_id] = *number;
  }
  const FrameNumbers* frames() const { return usable_ && !frames_.empty() ? &frames_ : nullptr; }

 private:
  FrameNumbers frames_;
  std::set<std::int64_t> unique_;
  bool usable_ = true;
};

// By the names of the images, else by those of the pictures, else by position: then `in_order` is how many there are.
FrameNumbers frame_numbers(const JsonValue& root, std::int64_t& in_order) {
  NumberedNames of_images;
  FrameNumbers counted;
  for (const JsonValue& image : root.at("images").elements()) {
    const std::int64_t id = image.at("id").integer(0, kMaxId);
    of_images.add(id, image.at("file_name").text());
    counted.emplace(id, static_cast<std::int64_t>(counted.size()));
  }
  if (const FrameNumbers* frames = of_images.frames()) return *frames;
  NumberedNames of_pictures;
  for (const JsonValue& annotation : root.at("annotations").elements()) {
    const std::int64_t id = annotation.at("image_id").integer(0, kMaxId);
    if (!counted.contains(id)) annotation.at("image_id").wrong("the id of an image");
    of_pictures.add(id, annotation.at("file_name").text());
  }
  if (const FrameNumbers* frames = of_pictures.frames()) return *frames;
  in_order = static_cast<std::int64_t>(counted.size());
  return counted;
}

LabelSet labels_of(const JsonValue& root) {
  const JsonValue categories = root.at("categories");
  std::vector<LabelClass> classes;
  for (const JsonValue& category : categories.elements()) {
    LabelClass c;
    c.id = static_cast<ClassId>(category.at("id").integer(1, kMaxClassId));
    c.name = category.at("name").text();
    c.is_thing = category.at("isthing").boolean();
    const std::optional<JsonValue> color = category.find("color");
    c.color = color && color->elements().size() == 3 ? color_in(*color) : Rgb{128, 128, 128};
    classes.push_back(std::move(c));
  }
  return label_set_of("coco", std::move(classes), categories);
}

// Category id -> class of the label set.
std::map<std::int64_t, ClassId> class_of_category(const JsonValue& root, const LabelSet& labels, const std::string& file) {
  std::map<std::int64_t, ClassId> classes;
  for (const JsonValue& category : root.at("categories").elements()) {
    const LabelClass* same = counterpart_of(category.at("name").text(), labels);
    classes[category.at("id").integer(0, kMaxId)] = same != nullptr ? same->id : ClassId::kUnknown;
  }
  if (std::all_of(classes.begin(), classes.end(), [](const auto& c) { return c.second == ClassId::kUnknown; })) {
    throw Error(
        fmt::format("{}: none of its {} categories has the name of a class of the label set '{}'; choose another label "
                    "set, or none to take the categories themselves",
                    file, classes.size(), labels.name()));
  }
  return classes;
}

// The categories of segments that the label set lacks, those with most segments first.
std::string unmatched_in(const JsonValue& root, const std::map<std::int64_t, ClassId>& classes, const LabelSet& labels) {
  std::map<std::int64_t, int> segments;
  for (const JsonValue& annotation : root.at("annotations").elements()) {
    for (const JsonValue& entry : annotation.at("segments_info").elements()) {
      const std::int64_t id = entry.at("category_id").integer(0, kMaxId);
      if (classes.at(id) == ClassId::kUnknown) ++segments[id];
    }
  }
  std::vector<std::pair<int, std::string>> found;
  for (const JsonValue& category : root.at("categories").elements()) {
    const auto count = segments.find(category.at("id").integer(0, kMaxId));
    if (count != segments.end()) found.emplace_back(count->second, category.at("name").text());
  }
  if (found.empty()) return "";
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  constexpr std::size_t kMostNamed = 8;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < found.size() && i < kMostNamed; ++i)
    names.push_back(fmt::format("{} ({} segments)", found[i].second, found[i].first));
  if (found.size() > kMostNamed) names.push_back(fmt::format("{} more", found.size() - kMostNamed));
  return fmt::format("the label set '{}' lacks categories of the predictions: {}", labels.name(), fmt::join(names, ", "));
}

CocoPanoptic::Picture to_picture(const JsonValue& annotation, const std::filesystem::path& folder,
                                 const std::map<std::int64_t, ClassId>& classes) {
  CocoPanoptic::Picture picture{folder / annotation.at("file_name").text(), {}};
  for (const JsonValue& entry : annotation.at("segments_info").elements()) {
    const auto category = classes.find(entry.at("category_id").integer(0, kMaxId));
    if (category == classes.end()) entry.at("category_id").wrong("the id of a category");
    const std::optional<JsonValue> score = entry.find("score");
    const std::optional<JsonValue> crowd = entry.find("iscrowd");
    picture.segments.push_back({static_cast<std::uint32_t>(entry.at("id").integer(1, kMaxSegmentId)), category->second,
                                score ? static_cast<float>(score->number(0, 1)) : 1.0F, crowd && crowd->boolean()});
  }
  auto& segments = picture.segments;
  std::sort(segments.begin(), segments.end(), [](const CocoSegment& a, const CocoSegment& b) { return a.id < b.id; });
  const auto twice =
      std::adjacent_find(segments.begin(), segments.end(), [](const auto& a, const auto& b) { return a.id == b.id; });
  if (twice != segments.end()) annotation.at("segments_info").wrong(fmt::format("without two segments of id {}", twice->id));
  if (segments.size() > kMaxSegments) annotation.at("segments_info").wrong(fmt::format("at most {} segments", kMaxSegments));
  return picture;
}

// The PNG files lie in the folder that is named like the JSON file, or beside it.
std::filesystem::path picture_folder(const std::filesystem::path& json) {
  const std::filesystem::path named = json.parent_path() / json.stem();
  return is_folder(named) ? named : json.parent_path();
}

// Which segment of the result each segment of the picture becomes, 0 = unknown.
std::vector<std::uint16_t> number_segments(const CocoPanoptic::Picture& picture, const LabelSet& labels,
                                           std::vector<Segment>& result) {
  std::map<ClassId, std::uint16_t> shared;  // of stuff, and of things that were not told apart
  std::vector<std::uint16_t> numbers;
  for (const CocoSegment& segment : picture.segments) {
    if (segment.class_id == ClassId::kUnknown) {
      numbers.push_back(0);
      continue;
    }
    const bool is_crowd = segment.is_crowd && labels.is_thing(segment.class_id);
    const bool is_shared = is_crowd || labels.is_stuff(segment.class_id);
    const auto seen = is_shared ? shared.find(segment.class_id) : shared.end();
    if (seen != shared.end()) {
      numbers.push_back(seen->second);
      continue;
    }
    result.push_back({segment.class_id, segment.score, {}, is_crowd});
    numbers.push_back(static_cast<std::uint16_t>(result.size()));
    if (is_shared) shared[segment.class_id] = numbers.back();
  }
  return numbers;
}

// The id of each pixel: red + 256 green + 65536 blue, or the value of a grey picture of 8 or 16 bits.
Image<std::uint32_t> ids_in(const std::filesystem::path& png) {
  const std::string bytes = read_png_bytes(png, 0, 0);
  const std::span<const std::uint8_t> view{reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
  if (const SampleKind kind = sample_kind(view); kind.channels == 1) {
    if (kind.bits < 8) throw Error(fmt::format("{}: a grey picture of {} bits; ids need 8 or 16", png.string(), kind.bits));
    const Image<std::uint16_t> grey = decode_gray16(view, png.string());
    return {grey.width(), grey.height(), std::vector<std::uint32_t>(grey.pixels().begin(), grey.pixels().end())};
  }
  const Image<Rgb> image = decode_rgb(view, png.string());
  Image<std::uint32_t> ids(image.width(), image.height());
  for (std::size_t i = 0; i < image.size(); ++i) ids[i] = image[i].r + 256U * image[i].g + 65536U * image[i].b;
  return ids;
}

}  // namespace

std::optional<std::filesystem::path> find_coco_panoptic(const std::filesystem::path& path) {
  if (is_file(path)) return path;
  std::optional<std::filesystem::path> only;
  for (const std::string& name : names_in_folder(path)) {
    if (!name.ends_with(".json")) continue;
    if (only) return std::nullopt;
    only = path / name;
  }
  return only;
}

CocoPanoptic read_coco_panoptic(const std::filesystem::path& json_path, const std::optional<LabelSet>& labels) {
  const std::string file = json_path.string();
  const Json json = read_json_file(json_path, kMaxJsonBytes);
  const JsonValue root(json, file);
  CocoPanoptic coco;
  coco.file = json_path;
  coco.labels = labels ? *labels : labels_of(root);
  const auto classes = class_of_category(root, coco.labels, file);
  const FrameNumbers frames = frame_numbers(root, coco.in_order);
  const std::filesystem::path folder = picture_folder(json_path);
  for (const JsonValue& annotation : root.at("annotations").elements()) {
    const auto frame = frames.find(annotation.at("image_id").integer(0, kMaxId));
    if (frame == frames.end()) annotation.at("image_id").wrong("the id of an image");
    if (!coco.pictures.emplace(frame->second, to_picture(annotation, folder, classes)).second) {
      annotation.at("image_id").wrong("the only annotation of its image");
    }
  }
  coco.unmatched = unmatched_in(root, classes, coco.labels);
  return coco;
}

Segmentation read_coco_frame(const CocoPanoptic& coco, std::int64_t frame_index) {
  const auto found = coco.pictures.find(frame_index);
  if (coco.in_order > 0 && frame_index >= coco.in_order) {
    throw Error(fmt::format(
        "{}: no picture for frame {}: their names have no numbers, so they are taken for frames 0 to {} in their order; "
        "put the frame's number into each name",
        coco.file.string(), frame_index, coco.in_order - 1));
  }
  if (found == coco.pictures.end()) return {};
  const CocoPanoptic::Picture& picture = found->second;
  const Image<std::uint32_t> image = ids_in(picture.png);
  Segmentation result{Image<std::uint16_t>(image.width(), image.height()), {}};
  const std::vector<std::uint16_t> numbers = number_segments(picture, coco.labels, result.segments);
  std::uint32_t last_id = 0;
  std::uint16_t last_number = 0;
  for (std::size_t i = 0; i < image.size(); ++i) {
    const std::uint32_t id = image[i];
    if (id != last_id) {
      const auto& all = picture.segments;
      const auto segment =
          std::lower_bound(all.begin(), all.end(), id, [](const CocoSegment& s, std::uint32_t value) { return s.id < value; });
      if (id != 0 && (segment == all.end() || segment->id != id)) {
        throw Error(
            fmt::format("{}: a pixel has the id {}, which is not in segments_info of its annotation", picture.png.string(), id));
      }
      last_id = id;
      last_number = id == 0 ? std::uint16_t{0} : numbers[static_cast<std::size_t>(segment - all.begin())];
    }
    result.segment_at[i] = last_number;
  }
  return result;
}

}  // namespace panoptic
