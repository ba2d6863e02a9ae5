// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The doctor on a list of recordings: each by itself, and whether they stand the same way up.
#pragma once

#include "panoptic/io/doctor.h"
#include "panoptic/io/recording_list.h"

namespace panoptic {

DoctorReport diagnose_list(const RecordingList& list, const DoctorOptions& options);

}  // namespace panoptic
