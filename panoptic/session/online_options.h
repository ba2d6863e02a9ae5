// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The options of mapping while frames arrive (session/online.h).
#pragma once

#include "panoptic/base/config.h"

namespace panoptic {

struct OnlineOptions {
  float mesh_every_s = 1;
  float regularize_every_s = 10;
  int waiting_frames = 15;  // between reading and fusion: half a second at 30 Hz
};
Fields fields(OnlineOptions& options);

}  // namespace panoptic
