// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Every option of the program by its name (base/config.h).
#pragma once

#include "panoptic/base/config.h"
#include "panoptic/options.h"

namespace panoptic {

Fields fields(Options& options);
Fields fields(OnlineOptions& options);

// Returns the options. Throws Error that names the first one out of its range, or two that contradict each other.
const Options& checked(const Options& options);

}  // namespace panoptic
