// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Functions that put each parametric shape together. Coordinates are those of the finished model: x from -w/2 to w/2, y from
// -d/2 (front) to d/2, z from 0 to h.
#pragma once

#include "panoptic/sim/model_builder.h"
#include "panoptic/sim/parametric.h"

namespace panoptic {

// parametric_openings.cpp
void make_curtain(const ParametricShape& shape, ModelBuilder& builder);
void make_door(const ParametricShape& shape, ModelBuilder& builder);
void make_picture(const ParametricShape& shape, ModelBuilder& builder);
void make_window(const ParametricShape& shape, ModelBuilder& builder);

// parametric_fixtures.cpp: kitchen, bathroom, heating
void make_basin(const ParametricShape& shape, ModelBuilder& builder);
void make_bathtub(const ParametricShape& shape, ModelBuilder& builder);
void make_counter(const ParametricShape& shape, ModelBuilder& builder);
void make_radiator(const ParametricShape& shape, ModelBuilder& builder);
void make_refrigerator(const ParametricShape& shape, ModelBuilder& builder);
void make_stove(const ParametricShape& shape, ModelBuilder& builder);

// parametric_furniture.cpp
void make_bin(const ParametricShape& shape, ModelBuilder& builder);
void make_bookshelf(const ParametricShape& shape, ModelBuilder& builder);
void make_floor_lamp(const ParametricShape& shape, ModelBuilder& builder);
void make_monitor(const ParametricShape& shape, ModelBuilder& builder);
void make_sideboard(const ParametricShape& shape, ModelBuilder& builder);

}  // namespace panoptic
