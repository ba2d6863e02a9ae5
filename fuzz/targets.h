// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The fuzz targets: one function per kind of input. Each takes any bytes and returns; a panoptic::Error of one line is a good
// end, everything else that goes wrong ends the process. docs/reliability.md tells what each reads.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace panoptic::fuzz {

using Input = std::span<const std::uint8_t>;

void bag(Input input);
void block_codec(Input input);
void coco(Input input);
void corrections(Input input);
void http(Input input);
void image(Input input);
void map_file(Input input);
void map_rows(Input input);
void ply(Input input);
void predictions(Input input);
void recording(Input input);
void results(Input input);
void resume(Input input);
void scan(Input input);
void sens(Input input);
void toml(Input input);
void video(Input input);

struct Target {
  std::string_view name;
  void (*run)(Input input);
};

std::span<const Target> targets();  // by name

}  // namespace panoptic::fuzz
