// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The classes that networks confuse, and how sure they are.
#pragma once

#include <cstdint>
#include <vector>

#include "panoptic/segmentation.h"
#include "panoptic/sim/prediction_noise.h"
#include "panoptic/sim/random.h"

namespace panoptic {

// The things of the label set that `class_id` is mistaken for, with weights that sum to 1, sorted by class. Empty where the
// table has none.
std::vector<ClassProbability> mistaken_for(ClassId class_id, const LabelSet& labels);

// Picks one of these classes by its weight; the class itself where there is none. `chance` in [0, 1).
ClassId pick_mistake(ClassId class_id, double chance, const LabelSet& labels);

// Picks the class of a thing that is found where there is nothing.
ClassId pick_hallucination(double chance, const LabelSet& labels);

// A score such that of all findings with score s the share s is correct, if score_mean of all findings are: Beta distributed
// with that mean, weighted by s for the correct and by 1 - s for the wrong ones.
float draw_score(bool correct, const PredictionNoise& noise, Random& random);

// The segment of a thing of class `truth` that was taken for `given`. Probabilities sum to 1, and `given` has the most.
Segment to_segment(ClassId truth, ClassId given, float score, const LabelSet& labels);

}  // namespace panoptic
