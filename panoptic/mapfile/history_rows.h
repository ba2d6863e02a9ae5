// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The history of objects as rows of a map file, in and out.
#pragma once

#include "panoptic/base/sqlite.h"
#include "panoptic/labels.h"
#include "panoptic/object_history.h"

namespace panoptic {

// Replaces the tables `past_objects` and `arrivals`.
void put_history(Database& database, const ObjectHistory& history);

// Reads them. Throws Error for contents that cannot be.
ObjectHistory read_history(Database& database, const LabelSet& labels);

}  // namespace panoptic
