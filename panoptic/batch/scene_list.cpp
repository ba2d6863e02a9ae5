// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/batch/scene_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

#include "panoptic/bag.h"
#include "panoptic/base/files.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestName = 200;  // of the 255 bytes that file systems have

// The files and folders of the batch itself, beside those of its scenes.
const std::set<std::string> kOwnNames = {"batch.json", "batch.md", "batch.lock", "scores.json", "scores.csv", "slurm"};

fs::path plain(const fs::path& path) {
  const fs::path normal = fs::absolute(path).lexically_normal();
  return normal.has_filename() ? normal : normal.parent_path();
}

// Empty for a comment too.
std::string trimmed(const std::string& line) {
  const std::size_t begin = line.find_first_not_of(" \t\r");
  if (begin == std::string::npos || line[begin] == '#') return "";
  return line.substr(begin, line.find_last_not_of(" \t\r") - begin + 1);
}

std::vector<std::string> recordings_in_file(const fs::path& list) {
  std::vector<std::string> recordings;
  std::istringstream lines(read_file(list));
  std::size_t number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const std::string text = trimmed(line);
    if (text.empty()) continue;
    const std::string recording = is_simulated(text) ? text : plain(plain(list).parent_path() / text).string();
    if (!is_simulated(text) && !is_there(path_of_recording(recording))) {
      throw Error(fmt::format("{}:{}: there is no {}; a line has the path of a recording, relative to the list, or sim:SEED",
                              list.string(), number, recording));
    }
    recordings.push_back(recording);
  }
  return recordings;
}

std::vector<std::string> recordings_in_folder(const fs::path& folder, const std::vector<fs::path>& own,
                                              std::vector<std::string>& left_out) {
  std::vector<std::string> recordings;
  for (const std::string& name : names_in_folder(folder)) {
    const fs::path path = plain(folder / name);
    const bool is_own = std::ranges::any_of(own, [&](const fs::path& o) { return plain(o) == path; });
    if (is_own || name.starts_with('.')) continue;
    if (is_folder(path) || path.extension() == ".sens" || is_bag_recording(path)) {
      recordings.push_back(path.string());
    } else {
      left_out.push_back(name);
    }
  }
  return recordings;
}

// The words of a recording's path, the last first: those that its name is made of.
std::vector<std::string> words_of(const std::string& recording) {
  if (is_simulated(recording)) return {recording};
  fs::path path = path_of_recording(recording);
  std::vector<std::string> words;
  const std::set<std::string> kForms = {".sens", ".toml", ".bag", ".mcap", ".db3"};
  const bool has_form = kForms.contains(path.extension().string());
  words.push_back((has_form ? path.stem() : path.filename()).string());
  for (path = path.parent_path(); path.has_filename(); path = path.parent_path()) words.push_back(path.filename().string());
  return words;
}

std::string folder_name(const std::string& text) {
  const auto is_good = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '.' || c == '_';
  };
  std::string name = text;
  std::replace_if(
      name.begin(), name.end(), [&](char c) { return !is_good(c); }, '_');
  if (name.starts_with('.')) name.front() = '_';
  return name;
}

std::string name_of(const std::vector<std::string>& words, std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < std::min(count, words.size()); ++i) text.insert(0, i == 0 ? words[i] : words[i] + "_");
  return folder_name(text);
}

std::map<std::string, std::size_t> counts_of(const std::vector<std::string>& names) {
  std::map<std::string, std::size_t> counts;
  for (const std::string& name : names) ++counts[name];
  return counts;
}

// One more folder in front of each name that several have, until none is shared or there are no folders left.
std::vector<std::string> distinct_names(const std::vector<std::string>& recordings) {
  std::vector<std::vector<std::string>> words;
  std::vector<std::string> names;
  std::vector<std::size_t> used(recordings.size(), 1);
  for (const std::string& recording : recordings) {
    words.push_back(words_of(recording));
    names.push_back(name_of(words.back(), 1));
  }
  for (bool changed = true; changed;) {
    changed = false;
    const auto counts = counts_of(names);
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (counts.at(names[i]) == 1 || used[i] >= words[i].size()) continue;
      names[i] = name_of(words[i], ++used[i]);
      changed = true;
    }
  }
  return names;
}

void require_good(const fs::path& list, const std::vector<BatchScene>& scenes) {
  std::map<std::string, std::string> recording_of;
  std::set<std::string> recordings;
  for (const BatchScene& scene : scenes) {
    if (!recordings.insert(scene.recording).second) {
      throw Error(fmt::format("{}: {} is named twice; leave one out", list.string(), scene.recording));
    }
    const auto [other, is_new] = recording_of.try_emplace(scene.name, scene.recording);
    if (!is_new) {
      throw Error(fmt::format("{}: {} and {} would both be called {}; rename one", list.string(), other->second, scene.recording,
                              scene.name));
    }
    if (kOwnNames.contains(scene.name) || scene.name.empty() || scene.name.size() > kLongestName) {
      throw Error(fmt::format("{}: a scene cannot be called '{}'; rename {}", list.string(), scene.name, scene.recording));
    }
  }
}

}  // namespace

bool is_simulated(const std::string& recording) { return recording.starts_with("sim:"); }

SceneList read_scenes(const fs::path& list_or_folder, const std::vector<fs::path>& own) {
  SceneList list;
  const std::vector<std::string> recordings =
      is_folder(list_or_folder) ? recordings_in_folder(list_or_folder, own, list.left_out) : recordings_in_file(list_or_folder);
  if (recordings.empty()) {
    throw Error(fmt::format("{}: no recordings here; a list has a path or sim:SEED a line, a folder has recordings in it",
                            list_or_folder.string()));
  }
  const std::vector<std::string> names = distinct_names(recordings);
  for (std::size_t i = 0; i < recordings.size(); ++i) list.scenes.push_back({names[i], recordings[i]});
  require_good(list_or_folder, list.scenes);
  return list;
}

}  // namespace panoptic
