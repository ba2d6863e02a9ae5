// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "apps/panoptic/arguments.h"

namespace panoptic {

// Writes the choice of topics behind the recording's name, where there is one. Throws UsageError for one that is not understood.
void take_topics(Arguments& a);

}  // namespace panoptic
