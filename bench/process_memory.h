// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace panoptic {

// The kernel's highest mark of resident memory starts anew; where it cannot be reset, it stays that of the whole process.
void reset_peak_memory();

// That mark, MB.
double peak_memory_mb();

}  // namespace panoptic
