// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/json.h"

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

#include "panoptic/base/files.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

// Counts the commas of every object and all, so that it is known before anything is built. Texts that are not JSON are the
// parser's.
bool is_crowded(std::string_view text) {
  constexpr std::int32_t kArray = -1;
  std::size_t values = 1;
  std::vector<std::int32_t> commas;  // of the objects that are open; kArray for arrays
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') {
      while (++i < text.size() && text[i] != '"') i += text[i] == '\\' ? 1 : 0;
    } else if (c == '{' || c == '[') {
      commas.push_back(c == '{' ? 0 : kArray);
    } else if ((c == '}' || c == ']') && !commas.empty()) {
      commas.pop_back();
    } else if (c == ',') {
      if (++values > kMostJsonValues) return true;
      if (commas.empty() || commas.back() == kArray) continue;
      if (++commas.back() >= static_cast<std::int32_t>(kMostJsonMembers)) return true;
    }
  }
  return false;
}

}  // namespace

std::optional<Json> json_in(std::string_view text) {
  if (is_crowded(text)) return std::nullopt;
  Json json = Json::parse(text, nullptr, false);
  return json.is_discarded() ? std::nullopt : std::optional(std::move(json));
}

Json read_json_file(const std::filesystem::path& path, std::uintmax_t max_bytes) {
  const std::string text = read_file(path, max_bytes);
  if (is_crowded(text)) {
    throw Error(fmt::format("{}: more than {} values, or an object with more than {} members; such a file is none of ours",
                            path.string(), kMostJsonValues, kMostJsonMembers));
  }
  try {
    return Json::parse(text);
  } catch (const Json::parse_error& e) {
    throw Error(fmt::format("{}: not valid JSON near byte {}: the file may be cut off", path.string(), e.byte));
  } catch (const Json::exception& e) {
    throw Error(fmt::format("{}: not usable JSON: {}", path.string(), e.what()));  // a number beyond the range of double
  }
}

void write_json_file(const std::filesystem::path& path, const Json& json) {
  write_file(path, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace panoptic
