// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "panoptic/base/config.h"
#include "panoptic/options.h"

namespace panoptic {

Fields fields(NetworkOptions& options);

}  // namespace panoptic
