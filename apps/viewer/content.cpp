// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/content.h"

#include <fmt/format.h>

#include <charconv>
#include <optional>
#include <random>
#include <string_view>
#include <utility>

#include "apps/viewer/messages.h"
#include "panoptic/error.h"
#include "panoptic/outputs.h"

namespace panoptic {
namespace {

constexpr std::size_t kMaxCacheBytes = std::size_t{64} << 20;
constexpr const char* kJson = "application/json";
constexpr const char* kBytes = "application/octet-stream";

std::string fresh_run_name() {
  std::random_device source;
  return fmt::format("{:08x}{:08x}", source(), source());
}

Answer said(int status, std::string_view sentence) {
  return {status, "text/plain; charset=utf-8", std::make_shared<const std::string>(fmt::format("{}\n", sentence)), ""};
}

Answer with(const char* type, std::string body) { return {200, type, std::make_shared<const std::string>(std::move(body)), ""}; }

Answer picture(const char* type, std::shared_ptr<const std::string> bytes) {
  if (bytes == nullptr) return said(404, "there is no such picture (yet)");
  return {200, type, std::move(bytes), ""};
}

// The whole text as one number.
template <typename Number>
std::optional<Number> number_in(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// "x,y,z,x,y,z,..."
std::optional<std::vector<BlockIndex>> blocks_in(std::string_view text) {
  std::vector<std::int32_t> numbers;
  while (numbers.size() < 3 * kMaxChunksAsked) {
    const std::size_t comma = text.find(',');
    const auto value = number_in<std::int32_t>(text.substr(0, comma));
    if (!value) return std::nullopt;
    numbers.push_back(*value);
    if (comma == std::string_view::npos) break;
    text.remove_prefix(comma + 1);
    if (numbers.size() == 3 * kMaxChunksAsked) return std::nullopt;
  }
  if (numbers.size() % 3 != 0) return std::nullopt;
  std::vector<BlockIndex> blocks;
  for (std::size_t i = 0; i < numbers.size(); i += 3) blocks.push_back({numbers[i], numbers[i + 1], numbers[i + 2]});
  return blocks;
}

}  // namespace

ViewerContent::ViewerContent(SnapshotScene scene, const LatestSnapshot& latest, PlaySource play, SceneHistory history)
    : scene_(std::move(scene)),
      latest_(latest),
      history_(std::move(history)),
      run_(fresh_run_name()),
      chunks_(scene_.block_size_m, kMaxCacheBytes),
      play_(std::move(play)),
      live_(scene_, latest_) {}

Answer ViewerContent::answer(const std::string& path, const Query& query) {
  if (path == "/api/scene.glb") return glb();
  if (path.starts_with("/api/play/")) return play_maker_.make([&] { return play(path, query); });
  return maker_.make([&] { return made(path, query); });
}

Answer ViewerContent::made(const std::string& path, const Query& query) {
  if (path == "/api/state") return state(query);
  if (path == "/api/chunks") return chunks(query);
  if (path == "/api/objects") return objects(query);
  if (path == "/api/scene") return with(kJson, scene_message(scene_, {run_, !history_.is_still(), play_.grows()}));
  if (path == "/api/history") return with(kJson, history_message(history_, scene_.labels));
  const auto newest = latest_.newest();
  if (path == "/api/frame.jpg") return picture("image/jpeg", pictures_.frame_jpeg(newest->frame));
  if (path == "/api/labelled.jpg") return picture("image/jpeg", pictures_.labelled_jpeg(newest->frame));
  if (path == "/api/overlay.png") return picture("image/png", pictures_.overlay_png(newest->frame, scene_.labels));
  return said(404, "nothing here");
}

std::string ViewerContent::event(const Snapshot& snapshot) const { return event_message(snapshot, run_); }

std::shared_ptr<const SnapshotSurface> ViewerContent::surface() {
  const std::lock_guard lock(surface_mutex_);
  auto newest = latest_.newest();
  if (surface_ == nullptr || surface_->snapshot().revision != newest->revision) {
    surface_ = std::make_shared<const SnapshotSurface>(std::move(newest));
  }
  return surface_;
}

void ViewerContent::forget() {
  const std::lock_guard lock(surface_mutex_);
  surface_ = nullptr;
  chunks_.clear();
  pictures_.clear();
}

Answer ViewerContent::state(const Query& query) {
  const auto since = query.find("since");
  const auto revision = since == query.end() ? 0 : number_in<std::uint64_t>(since->second);
  if (!revision) return said(400, "since is not a revision");
  return with(kJson, state_message(*surface(), *revision));
}

Answer ViewerContent::objects(const Query&) { return with(kJson, objects_message(*latest_.newest(), scene_.labels)); }

Answer ViewerContent::chunks(const Query& query) {
  const auto keys = query.find("k");
  const auto blocks = keys == query.end() ? std::nullopt : blocks_in(keys->second);
  if (!blocks) return said(400, fmt::format("k is not x,y,z of 1 to {} chunks, joined by commas", kMaxChunksAsked));
  const auto newest = surface();
  std::vector<std::shared_ptr<const std::string>> found;
  for (const BlockIndex block : *blocks) {
    const std::size_t chunk = newest->find(block);
    if (chunk != SnapshotSurface::kNoChunk) found.push_back(chunks_.encoded(*newest, chunk));
  }
  return with(kBytes, join_chunks(found));
}

// On play_maker_, like the next. Throws Error where there is none.
const ScenePlan& ViewerContent::plan(const Query& query) {
  if (!play_.grows()) return play_.plan();
  const auto asked = query.find("r");
  const auto revision = asked == query.end() ? std::nullopt : number_in<std::uint64_t>(asked->second);
  return live_.of(revision.value_or(0));
}

Answer ViewerContent::play(const std::string& path, const Query& query) {
  try {
    if (path == "/api/play/plan.json" && play_.grows()) return with(kJson, live_.newest());
    if (path == "/api/play/navmesh.bin") return with(kBytes, plan(query).navmesh);
    if (path == "/api/play/walls.bin") return with(kBytes, plan(query).walls);
    if (path == "/api/play/walls.json") return with(kJson, plan(query).walls_index);
    if (path == "/api/play/affordances.json") return with(kJson, plan(query).affordances);
    if (path == "/api/play/frames.json") return with(kJson, play_.frames());
    if (path == "/api/play/distances.json") return with(kJson, play_.distances());
    const auto numbered = [&](const char* type, std::string (PlaySource::*read)(std::size_t)) {
      const auto asked = query.find("n");
      const auto place = asked == query.end() ? std::nullopt : number_in<std::size_t>(asked->second);
      return place ? with(type, (play_.*read)(*place)) : said(400, "n is not a place in frames.json or distances.json, from 0");
    };
    if (path == "/api/play/frame.json") return numbered(kJson, &PlaySource::frame);
    if (path == "/api/play/frame.jpg") return numbered("image/jpeg", &PlaySource::picture);
    if (path == "/api/play/slice.png") return numbered("image/png", &PlaySource::slice);
    return said(404, "nothing here");
  } catch (const Error& e) {
    return said(404, e.what());
  }
}

Answer ViewerContent::glb() {
  if (is_making_glb_.exchange(true)) return said(503, "another download of the scene is being made; try again");
  try {
    Answer answer = glb_maker_.make([this] {
      const auto newest = surface();
      const Vec3d up = newest->snapshot().up.cast<double>();
      return with("model/gltf-binary", glb_bytes(newest->assemble(scene_.labels), scene_.labels, up));
    });
    answer.download_name = "scene.glb";
    is_making_glb_ = false;
    return answer;
  } catch (...) {
    is_making_glb_ = false;
    throw;
  }
}

}  // namespace panoptic
