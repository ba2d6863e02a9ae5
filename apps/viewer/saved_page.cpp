// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/saved_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include "apps/viewer/assets.h"
#include "apps/viewer/content.h"
#include "panoptic/base/files.h"
#include "panoptic/base/json.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostSlices = 16;
constexpr std::string_view kModuleScript = R"(<script type="module" src="/assets/page.js"></script>)";

std::string base64(std::string_view bytes) {
  constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0);
    for (std::size_t k = 0; k < 4; ++k) text.push_back(i + k > bytes.size() ? '=' : kLetters[group >> (18 - 6 * k) & 63]);
  }
  return text;
}

void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
}

// From one to the next, so that no more than `most` of `count` are taken.
std::size_t stride_through(std::size_t count, std::size_t most) { return std::max<std::size_t>(1, (count + most - 1) / most); }

std::string_view asset(std::string_view path) {
  const auto assets = web_assets();
  const auto found = std::find_if(assets.begin(), assets.end(), [&](const WebAsset& a) { return a.path == path; });
  if (found == assets.end()) {
    throw Error("export-web: this program was built without its page: run scripts/setup and build again");
  }
  return found->bytes;
}

// Asks for everything that a page asks for, and writes the answers as scripts.
class PageWriter {
 public:
  PageWriter(const fs::path& folder, ViewerContent& content) : folder_(folder), content_(content) {}

  SavedPage write(std::size_t most_frames) {
    const std::string page(asset("/"));
    const std::string_view script = asset("/assets/saved.js");
    if (is_folder(folder_) && !names_in_folder(folder_).empty()) {
      throw Error(fmt::format("{} holds files already: choose a folder that is absent or empty", folder_.string()));
    }
    require_writable_folder(folder_ / "assets");
    require_writable_folder(folder_ / "data");
    put("assets/saved.js", script);
    for (const char* name : {"page.css", "icon.svg"}) put(fmt::format("assets/{}", name), asset(fmt::format("/assets/{}", name)));
    for (const char* path : {"/api/scene", "/api/state", "/api/objects", "/api/history"}) keep(path, path, {});
    close("map.js");
    keep_chunks();
    keep_plan();
    keep_slices();
    keep_frames(most_frames);
    write_index(page);
    return std::move(saved_);
  }

 private:
  void put(const std::string& name, std::string_view bytes) {
    write_file(folder_ / name, bytes);
    saved_.bytes += bytes.size();
    ++saved_.files;
  }

  void keep_text(std::string_view name, std::string_view bytes) {
    script_ += fmt::format("panoptic_saved[{}]=\"{}\";\n", Json(name).dump(), base64(bytes));
  }

  // The answer, which may be empty; nothing, with a note, if there is none.
  std::optional<std::string> keep(const std::string& name, const std::string& path, const Query& query) {
    const Answer answer = content_.answer(path, query);
    if (answer.status != 200) {
      std::string why = *answer.body;
      while (!why.empty() && why.back() == '\n') why.pop_back();
      script_ += fmt::format("panoptic_saved['/why_not'] = panoptic_saved['/why_not'] || {};\n", Json(why).dump());
      if (std::find(saved_.notes.begin(), saved_.notes.end(), why) == saved_.notes.end()) saved_.notes.push_back(why);
      return std::nullopt;
    }
    keep_text(name, *answer.body);
    return *answer.body;
  }

  void close(const std::string& name) {
    put(fmt::format("data/{}", name), fmt::format("globalThis.panoptic_saved = globalThis.panoptic_saved || {{}};\n{}", script_));
    scripts_ += fmt::format("<script defer src=\"data/{}\"></script>\n  ", name);
    script_.clear();
  }

  void keep_chunks() {
    const Answer state = content_.answer("/api/state", {});
    const Json chunks = Json::parse(*state.body)["chunks"];
    std::size_t part = 0;
    for (std::size_t first = 0; first < chunks.size(); first += kMaxChunksAsked) {
      std::string keys;
      for (std::size_t i = first; i < std::min(chunks.size(), first + kMaxChunksAsked); ++i) {
        keys += fmt::format("{}{}", keys.empty() ? "" : ",", chunks[i][0].get<std::string>());
      }
      keep(fmt::format("/api/chunks?part={}", part++), "/api/chunks", {{"k", keys}});
    }
    close("surface.js");
  }

  void keep_plan() {
    for (const char* name : {"affordances.json", "navmesh.bin", "walls.bin", "walls.json"}) {
      const std::string path = fmt::format("/api/play/{}", name);
      if (!keep(path, path, {})) break;
    }
    close("play.js");
  }

  // At most kMostSlices of the heights, evenly apart.
  void keep_slices() {
    const Answer answer = content_.answer("/api/play/distances.json", {});
    if (answer.status != 200) {
      keep("/api/play/distances.json", "/api/play/distances.json", {});
      return close("distances.js");
    }
    Json distances = Json::parse(*answer.body);
    const Json heights = std::exchange(distances["heights_m"], Json::array());
    const std::size_t stride = stride_through(heights.size(), kMostSlices);
    for (std::size_t i = 0; i < heights.size(); i += stride) {
      keep(fmt::format("/api/play/slice.png?n={}", distances["heights_m"].size()), "/api/play/slice.png",
           {{"n", fmt::format("{}", i)}});
      distances["heights_m"].push_back(heights[i]);
    }
    keep_text("/api/play/distances.json", distances.dump());
    close("distances.js");
  }

  void keep_frames(std::size_t most) {
    const Answer answer = content_.answer("/api/play/frames.json", {});
    if (answer.status != 200 || most == 0) {
      if (most > 0) keep("/api/play/frames.json", "/api/play/frames.json", {});
      return close("frames.js");
    }
    const Json all = Json::parse(*answer.body)["frames"];
    const std::size_t stride = stride_through(all.size(), most);
    Json kept = Json::array();
    for (std::size_t i = 0; i < all.size(); i += stride) {
      const Query query = {{"n", fmt::format("{}", i)}};
      const std::size_t place = kept.size();
      if (!keep(fmt::format("/api/play/frame.json?n={}", place), "/api/play/frame.json", query)) continue;
      if (keep(fmt::format("/api/play/frame.jpg?n={}", place), "/api/play/frame.jpg", query)) kept.push_back(all[i]);
    }
    saved_.frames = kept.size();
    keep_text("/api/play/frames.json", Json{{"frames", std::move(kept)}}.dump());
    close("frames.js");
  }

  void write_index(std::string page) {
    if (page.find(kModuleScript) == std::string::npos) throw Error("export-web: the page has no script where it was expected");
    replace_all(page, kModuleScript, scripts_ + "<script defer src=\"assets/saved.js\"></script>");
    replace_all(page, "\"/assets/", "\"assets/");
    put("index.html", page);
  }

  const fs::path& folder_;
  ViewerContent& content_;
  SavedPage saved_;
  std::string script_;   // of the file that is being put together
  std::string scripts_;  // for index.html
};

}  // namespace

SavedPage save_page(const fs::path& folder, OpenedResult result, PlaySource play, std::size_t most_frames) {
  LatestSnapshot latest;
  latest.publish(std::move(result.snapshot));
  ViewerContent content(std::move(result.scene), latest, std::move(play), std::move(result.history));
  return PageWriter(folder, content).write(most_frames);
}

}  // namespace panoptic
