// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Classes in JSON files. Everything throws Error that names the place.
#pragma once

#include <string>
#include <vector>

#include "panoptic/base/json.h"
#include "panoptic/base/json_value.h"
#include "panoptic/labels.h"

namespace panoptic {

// [red, green, blue]
Json color_json(const Rgb& color);
Rgb color_in(const JsonValue& value);

// [{id, name, is_thing, color}], as reports and predictions have them. What is read may have max_size_m, is_support and is_mobile
// too.
Json classes_json(const LabelSet& labels);
std::vector<LabelClass> classes_in(const JsonValue& list);

// The classes that were read at `place`, which is named if they do not go together.
LabelSet label_set_of(std::string name, std::vector<LabelClass> classes, const JsonValue& place);

}  // namespace panoptic
