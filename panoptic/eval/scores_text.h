// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Scores for people and programs. Fractions 0..1 in JSON and CSV, percent in the table.
#pragma once

#include <string>

#include "panoptic/base/json.h"
#include "panoptic/evaluation.h"

namespace panoptic {

// Scores by key, of all that was evaluated: `miou`; `ap`, `ap50`, `ap25`, `class_agnostic`; `pq`, `sq`, `rq` (each {all,
// things, stuff}), `variant`, `rules`, `pq_variants`; `surface`; `coverage`, `scenes`, `per_class` by class name. Undefined is
// null.
Json to_json(const Scores& scores);

// One line per class; undefined is nan. Instance scores alone give the benchmark's own header.
std::string to_csv(const Scores& scores);

}  // namespace panoptic
