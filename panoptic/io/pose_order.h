// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Poses in a list without names beside images whose order as text is another than that of their numbers: a program that sorts
// names as text wrote 1, 10, 2. Which order the list has shows by the images themselves.
#pragma once

#include "panoptic/io/dataset_files.h"

namespace panoptic {

// Takes the order whose poses agree with the depth images clearly better; where depth says nothing (its scale may be wrong, too),
// the one in which the camera moves in much smaller steps. Says in `assumed` which. Does nothing if the recording leaves no
// choice. Throws Error if neither order is clearly right.
void settle_pose_order(FileRecording& recording);

}  // namespace panoptic
