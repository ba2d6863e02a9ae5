// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The files of the page, compiled in (cmake/web_assets.cmake writes the definition).
#pragma once

#include <span>
#include <string_view>

namespace panoptic {

struct WebAsset {
  std::string_view path;  // "/" is the page itself
  std::string_view type;
  std::string_view bytes;
  std::string_view gzipped;  // the same compressed; empty where it is not worth it
};

// All files of the page; empty if the page was not built.
std::span<const WebAsset> web_assets();

}  // namespace panoptic
