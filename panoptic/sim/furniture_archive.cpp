// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/furniture_archive.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <span>
#include <utility>

#include "panoptic/base/image_header.h"
#include "panoptic/base/image_io.h"
#include "panoptic/error.h"
#include "panoptic/sim/obj_model.h"

namespace panoptic {
namespace {

constexpr const char* kList = "PluginFurnitureCatalog.properties";
constexpr std::size_t kMaxListBytes = 8U << 20;
constexpr std::size_t kMaxTextBytes = 48U << 20;
constexpr std::size_t kMaxTextureBytes = 32U << 20;
constexpr std::size_t kMaxTexturePixels = 16U << 20;
constexpr int kTextureSide_px = 512;
constexpr float kInvisible = 0.05F;
constexpr float kMaxSize_m = 100;

using Properties = std::map<std::string, std::string, std::less<>>;  // of one entry of the list

// Properties by the number behind the '#'.
std::map<int, Properties> parse_list(std::string_view text) {
  std::map<int, Properties> entries;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    const std::size_t equals = line.find('=');
    const std::size_t hash = line.find('#');
    if (line.starts_with('#') || equals == std::string_view::npos || hash > equals) continue;
    int number = 0;
    const char* digits_end = line.data() + equals;
    if (std::from_chars(line.data() + hash + 1, digits_end, number).ptr != digits_end) continue;
    entries[number].emplace(line.substr(0, hash), line.substr(equals + 1));
  }
  return entries;
}

std::string value_of(const Properties& properties, std::string_view key) {
  const auto found = properties.find(key);
  return found == properties.end() ? "" : found->second;
}

// Numbers between spaces; what is no number ends them.
std::vector<float> numbers_in(const std::string& text) {
  std::vector<float> numbers;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (at != end) {
    float number = 0;
    const auto [next, error] = std::from_chars(at, end, number);
    if (error != std::errc()) break;
    numbers.push_back(number);
    at = std::find_if(next, end, [](char c) { return c != ' '; });
  }
  return numbers;
}

float metres(const Properties& properties, std::string_view key) {
  const std::vector<float> cm = numbers_in(value_of(properties, key));
  return cm.size() == 1 ? cm[0] / 100 : 0;
}

// Names are Latin-1 in the list and UTF-8 here.
std::string to_utf8(std::string_view latin1) {
  std::string text;
  for (const char c : latin1) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x80) {
      text += c;
    } else {
      text += static_cast<char>(0xC0U | (code >> 6U));
      text += static_cast<char>(0x80U | (code & 0x3FU));
    }
  }
  return text;
}

ArchiveEntry to_entry(const Properties& properties, const std::string& where) {
  ArchiveEntry entry;
  const std::string id = value_of(properties, "id");
  entry.id = id.substr(id.find('#') + 1);
  entry.name = to_utf8(value_of(properties, "name"));
  entry.model_path = value_of(properties, "model");
  if (entry.model_path.starts_with('/')) entry.model_path.erase(0, 1);
  entry.size_m = {metres(properties, "width"), metres(properties, "depth"), metres(properties, "height")};
  entry.elevation_m = metres(properties, "elevation");
  const bool sane = entry.size_m.allFinite() && entry.size_m.minCoeff() > 0 && entry.size_m.maxCoeff() < kMaxSize_m &&
                    std::isfinite(entry.elevation_m) && std::abs(entry.elevation_m) < kMaxSize_m;
  if (entry.id.empty() || entry.model_path.empty() || !sane)
    throw Error(fmt::format("{}: entry '{}' lacks an id, a model or a size between 0 and {} m", where, id, kMaxSize_m));
  const std::string rotation = value_of(properties, "modelRotation");
  if (rotation.empty()) return entry;
  const std::vector<float> numbers = numbers_in(rotation);
  if (numbers.size() != 9) throw Error(fmt::format("{}: entry '{}': modelRotation is not nine numbers", where, id));
  entry.rotation = Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(numbers.data());
  if (!entry.rotation.allFinite() || std::abs(std::abs(entry.rotation.determinant()) - 1) > 0.01F)
    throw Error(fmt::format("{}: entry '{}': modelRotation is no rotation", where, id));
  return entry;
}

Image<Rgb> decode_texture(const std::string& bytes, const std::string& name) {
  const std::span<const std::uint8_t> span(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  if (!is_acceptable_image(span, kMaxTexturePixels))
    throw Error(fmt::format("{}: not a readable image of at most {} pixels", name, kMaxTexturePixels));
  Image<Rgb> image = decode_rgb(span, name);
  const int side = std::max(image.width(), image.height());
  if (side <= kTextureSide_px) return image;
  Image<Rgb> small(std::max(1, image.width() * kTextureSide_px / side), std::max(1, image.height() * kTextureSide_px / side));
  cv::Mat to(small.height(), small.width(), CV_8UC3, small.data());
  cv::resize(cv::Mat(image.height(), image.width(), CV_8UC3, image.data()), to, to.size(), 0, 0, cv::INTER_AREA);
  return small;
}

bool is_absolute(const std::string& path) { return path.starts_with('/') || path.find(':') != std::string::npos; }

std::string folder_of(const std::string& path) { return path.substr(0, path.rfind('/') + 1); }

// The file's y is up and its z to the front; ours are z and -y.
void to_our_axes(const Eigen::Matrix3f& rotation, SceneModel& model) {
  Eigen::Matrix3f ours_from_file;
  ours_from_file << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  const Eigen::Matrix3f turn = ours_from_file * rotation;
  for (Vec3f& p : model.positions) p = turn * p;
}

// Without the faces of the materials that cannot be seen, and without the vertices that nothing refers to then, which would
// count in the bounding box.
SceneModel visible_part(const ObjModel& obj) {
  constexpr std::uint32_t unused = 0xFFFFFFFFU;
  SceneModel model;
  std::vector<std::uint32_t> new_index(obj.model.positions.size(), unused);
  for (std::size_t t = 0; t < obj.model.triangles.size(); ++t) {
    if (obj.materials[obj.model.material_of[t]].opacity < kInvisible) continue;
    std::array<std::uint32_t, 3> triangle = obj.model.triangles[t];
    for (std::uint32_t& vertex : triangle) {
      std::uint32_t& index = new_index[vertex];
      if (index == unused) {
        index = static_cast<std::uint32_t>(model.positions.size());
        model.positions.push_back(obj.model.positions[vertex]);
        model.uvs.push_back(obj.model.uvs[vertex]);
      }
      vertex = index;
    }
    model.triangles.push_back(triangle);
    model.material_of.push_back(obj.model.material_of[t]);
  }
  return model;
}

}  // namespace

FurnitureArchive::FurnitureArchive(const std::filesystem::path& path) : zip_(path) {
  const std::string where = fmt::format("{}/{}", path.string(), kList);
  for (const auto& [number, properties] : parse_list(zip_.read(kList, kMaxListBytes)))
    entries_.push_back(to_entry(properties, where));
}

const ArchiveEntry* FurnitureArchive::find(std::string_view id) const {
  const auto found = std::find_if(entries_.begin(), entries_.end(), [&](const ArchiveEntry& e) { return e.id == id; });
  return found == entries_.end() ? nullptr : &*found;
}

ModelAsset FurnitureArchive::load(const ArchiveEntry& entry) const {
  const std::string where = fmt::format("{}/{}", zip_.path().string(), entry.model_path);
  const std::string folder = folder_of(entry.model_path);
  const std::string obj_text = zip_.read(entry.model_path, kMaxTextBytes);
  const std::string library = material_library(obj_text);
  const ObjModel obj = parse_obj(obj_text, library.empty() ? "" : zip_.read(folder + library, kMaxTextBytes), where);

  ModelAsset asset;
  asset.model = visible_part(obj);
  if (asset.model.triangles.empty()) throw Error(fmt::format("{}: all its faces are invisible", where));
  asset.model.name = entry.name;
  to_our_axes(entry.rotation, asset.model);
  std::map<std::string, std::int32_t> texture_index;
  for (const ObjMaterial& material : obj.materials) {
    asset.materials.push_back({material.color, -1});
    if (material.texture.empty() || is_absolute(material.texture)) continue;
    const auto [found, is_new] = texture_index.try_emplace(material.texture, static_cast<std::int32_t>(asset.textures.size()));
    if (is_new) {
      const std::string path = folder + material.texture;
      asset.textures.push_back(
          decode_texture(zip_.read(path, kMaxTextureBytes), fmt::format("{}/{}", zip_.path().string(), path)));
    }
    // Many authors leave Kd at a grey or at black beside a texture, so the texture alone decides.
    asset.materials.back() = {{255, 255, 255}, found->second};
  }
  return asset;
}

}  // namespace panoptic
