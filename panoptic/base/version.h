// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace panoptic {

const char* version();  // "0.1.0"

}  // namespace panoptic
