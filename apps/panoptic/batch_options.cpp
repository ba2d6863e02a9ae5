// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/panoptic/batch_options.h"

#include <fmt/format.h>

namespace panoptic {
namespace {

namespace fs = std::filesystem;

std::string replaced(std::string text, const std::string& mark, const std::string& by) {
  for (std::size_t at = text.find(mark); at != std::string::npos; at = text.find(mark, at + by.size())) {
    text.replace(at, mark.size(), by);
  }
  return text;
}

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

void require_own_inputs(const Words& run_options, std::size_t scenes) {
  for (const char* option : {"--predictions", "--pose-updates"}) {
    for (std::size_t i = 0; i < run_options.size(); ++i) {
      const std::string& word = run_options[i];
      std::string value;
      if (word == option && i + 1 < run_options.size()) value = run_options[i + 1];
      if (word.starts_with(std::string(option) + "=")) value = word;
      if (value.empty() || scenes < 2 || value.find("{}") != std::string::npos || value.find("{name}") != std::string::npos)
        continue;
      throw UsageError(
          fmt::format("{} after --: all scenes would have the same; write {{}} for a scene's path or {{name}} for its "
                      "name, like {} {{}}/predictions",
                      option, option));
    }
  }
}

}  // namespace panoptic
