// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/json.h"

#include <fmt/format.h>

#include "panoptic/base/error.h"
#include "panoptic/base/files.h"

namespace panoptic {

Json read_json_file(const std::filesystem::path& path, std::uintmax_t max_bytes) {
  const std::string text = read_file(path, max_bytes);
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
