// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/version.h"

namespace panoptic {

const char* version() { return PANOPTIC_VERSION; }

}  // namespace panoptic
