// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace panoptic {

constexpr std::uint16_t kNyu40Classes = 40;  // numbered from 1

// The classes of NYU Depth V2 in its 40-class form, as ScanNet names them.
inline constexpr std::array<std::string_view, kNyu40Classes> kNyu40Names = {
    "wall",       "floor",          "cabinet",        "bed",
    "chair",      "sofa",           "table",          "door",
    "window",     "bookshelf",      "picture",        "counter",
    "blinds",     "desk",           "shelves",        "curtain",
    "dresser",    "pillow",         "mirror",         "floor mat",
    "clothes",    "ceiling",        "books",          "refrigerator",
    "television", "paper",          "towel",          "shower curtain",
    "box",        "whiteboard",     "person",         "night stand",
    "toilet",     "sink",           "lamp",           "bathtub",
    "bag",        "otherstructure", "otherfurniture", "otherprop"};

}  // namespace panoptic
