// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Furniture in a floor plan: outlines with the few lines by which people know a bed from a sofa, and names where they fit.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "panoptic/base/polygon.h"
#include "panoptic/home_plan.h"

namespace panoptic {

// SVG elements. `to_sheet` takes metres of the plan to centimetres of the drawing, without scaling one axis more than the other.
std::string furniture_svg(const HomePlan& plan, const LabelSet& labels, const std::function<Vec2d(const Vec2d&)>& to_sheet);

// The text as it stands between tags.
std::string as_xml(std::string_view text);

}  // namespace panoptic
