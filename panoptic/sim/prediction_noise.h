// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Turns true masks into predictions like those of networks. Presets: "oracle", "good", "maskrcnn" (single-frame PQ about 40),
// "poor".
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "panoptic/base/config.h"
#include "panoptic/labels.h"
#include "panoptic/segmentation.h"
#include "panoptic/sim/simulation.h"

namespace panoptic {

// The defaults are the oracle. Every chance is that of one thing in one frame; object_share and view_share say how much of it
// is the same in all frames. docs/simulator.md tells which chances are drawn where.
struct PredictionNoise {
  float missed = 0;           // chance that a thing is not found although it is near, large and whole
  float small_px = 0;         // of things with a mask of this many pixels half are missed besides; of larger ones fewer
  float far_m = 0;            // of things at this distance half are missed besides; 0 = distance does not matter
  float truncated = 0;        // chance that a thing is not found besides, because the image cuts it off
  float merged = 0;           // chance that two touching things of one class are given as one
  float split = 0;            // chance that a thing is given as two parts
  float hallucinated = 0;     // chance that something is found in a place (0.6 m wide) where there is nothing
  float boundary_px = 0;      // standard deviation of the boundary's displacement, smooth along the boundary
  float boundary_share = 0;   // and as a share of the thing's size (root of its area)
  float confused = 0;         // chance of a wrong class, after the table of what is taken for what
  float score_mean = 1;       // share of correct findings that the network expects; 1 = every score is 1
  float score_certainty = 4;  // the smaller, the nearer scores are to 0 and 1
  float stuff_lost = 0;       // share of wall and floor that is given as unknown
  float stuff_swapped = 0;    // share of wall that is given as floor and of floor that is given as wall
  float things_as_stuff = 0;  // share of things' and void surface that the semantic network takes for wall or floor
  float patch_m = 0.5F;       // size of the patches of the three above
  float object_share = 0.4F;  // share of chance that belongs to the thing or place: the same in every frame
  float view_share = 0.4F;    // share that belongs to the place of the camera; the rest changes from frame to frame
  float view_m = 0.4F;        // how far the camera must move for the view to be another
};
Fields fields(PredictionNoise& noise);

// Throws Error listing the presets if there is none of that name.
PredictionNoise prediction_noise_preset(const std::string& name);
const std::vector<std::string>& prediction_noise_presets();

// The prediction that networks would give for the frame, fused as theirs is (Eq. 1); segments have an order of their own in
// every frame. `labels` is the label set of the scene's classes. Depends on (noise, seed, frame) alone. Any thread.
Segmentation predict_with_noise(const PredictionNoise& noise, std::uint64_t seed, const SimulatedFrame& frame,
                                const LabelSet& labels);

}  // namespace panoptic
