// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/panoptic/batch_options.h"

#include <fmt/format.h>

#include <set>

namespace panoptic {
namespace {

namespace fs = std::filesystem;

std::string replaced(std::string text, const std::string& mark, const std::string& by) {
  for (std::size_t at = text.find(mark); at != std::string::npos; at = text.find(mark, at + by.size())) {
    text.replace(at, mark.size(), by);
  }
  return text;
}

// Without links as far as it is there, and without a slash at the end.
fs::path real(const fs::path& path) {
  const fs::path whole = fs::weakly_canonical(fs::absolute(path)).lexically_normal();
  return whole.has_filename() ? whole : whole.parent_path();
}

// Or is the folder.
bool is_within(const fs::path& path, const fs::path& folder) {
  const fs::path relative = path.lexically_relative(folder);
  return !relative.empty() && *relative.begin() != "..";
}

bool are_entangled(const fs::path& a, const fs::path& b) { return is_within(a, b) || is_within(b, a); }

}  // namespace

Words options_for(const BatchScene& scene, const Words& run_options) {
  Words words;
  for (const std::string& word : run_options) {
    words.push_back(replaced(replaced(word, "{name}", scene.name), "{}", scene.recording));
  }
  return words;
}

Words without(const Words& words, const std::string& option) {
  Words kept;
  bool in_option = false;
  for (const std::string& word : words) {
    if (word.starts_with('-')) in_option = word == option || word.starts_with(option + "=");
    if (!in_option) kept.push_back(word);
  }
  return kept;
}

void require_allowed(const Words& run_options) {
  for (const std::string& word : run_options) {
    const std::string name = word.substr(0, word.find('='));
    for (const char* own : {"--output", "--map", "--resume", "--checkpoint-every"}) {
      if (name == own || word.starts_with("-o")) {
        throw UsageError(fmt::format("{} after --: batch gives each scene its own output; leave it out", name));
      }
    }
    for (const char* live : {"--view", "--bind", "--port", "--token"}) {
      if (name == live) throw UsageError(fmt::format("{} after --: nobody looks on in a batch; leave it out", name));
    }
    if (word == "-h" || word == "--help" || word == "--version") {
      throw UsageError(fmt::format("{} after --: see panoptic run --help", word));
    }
  }
}

Arguments run_arguments(const BatchScene& scene, const fs::path& folder, const Words& options) {
  Words words{"panoptic", "run", scene.recording, "-o", folder.string()};
  words.insert(words.end(), options.begin(), options.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  try {
    return parse_arguments(static_cast<int>(argv.size()), argv.data());
  } catch (const UsageError& e) {
    throw UsageError(fmt::format("after --: {}", e.what()));
  }
}

void require_own_input(const std::string& what, const std::string& path, const BatchScene& scene, InputOwners& owners) {
  if (path.empty()) return;
  const auto [owner, is_new] = owners.try_emplace(real(path), scene.name);
  if (is_new) return;
  throw UsageError(fmt::format(
      "{}: the scenes {} and {} would have the same {}; give each its own after --, with {{}} for its path or {{name}} "
      "for its name, like --predictions {{}}/predictions",
      what, owner->second, scene.name, path));
}

void require_apart(const Arguments& arguments, const std::vector<BatchScene>& scenes) {
  const fs::path output = real(arguments.output);
  const fs::path shared = arguments.shared_predictions.empty() ? fs::path() : real(arguments.shared_predictions);
  if (!shared.empty() && are_entangled(output, shared)) {
    throw Error(fmt::format("--share-predictions {} and the output {} lie in each other; choose another folder for one of them",
                            arguments.shared_predictions, arguments.output));
  }
  std::set<std::string> names;
  for (const BatchScene& scene : scenes) names.insert(scene.name);
  for (const BatchScene& scene : scenes) {
    if (is_simulated(scene.recording)) continue;
    const fs::path recording = real(scene.recording);
    const bool is_in_a_scene =
        is_within(recording, output) && names.contains(recording.lexically_relative(output).begin()->string());
    if (is_in_a_scene || is_within(output, recording) || are_entangled(real(output / scene.name), recording)) {
      throw Error(
          fmt::format("the output {} of the scene {} and the recording {} lie in each other; choose another output folder",
                      (output / scene.name).string(), scene.name, scene.recording));
    }
    if (!shared.empty() && are_entangled(shared, recording)) {
      throw Error(fmt::format("--share-predictions {} and the recording {} lie in each other; choose another folder",
                              arguments.shared_predictions, scene.recording));
    }
  }
}

void require_flags_for_networks(const Words& settings) {
  for (const std::string& setting : settings) {
    const std::string key = setting.substr(0, setting.find('='));
    for (const char* network : {"semantic", "instance"}) {
      if (key.find(fmt::format("networks.{}", network)) == std::string::npos) continue;
      throw UsageError(fmt::format("--set {} after -- does not go with --share-predictions; use --{} instead", setting, network));
    }
  }
}

}  // namespace panoptic
