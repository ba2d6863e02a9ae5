// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A predictor that reads what was predicted before: runs without networks that give the same map every time.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "panoptic/data/labels.h"
#include "panoptic/predict/predictor.h"

namespace panoptic {

// `path` is a folder that PredictionWriter filled, or COCO panoptic: its JSON file or a folder with that as the only JSON
// file. Frames are found by Frame::index; a frame without prediction gives an empty segmentation. Without `labels` the
// predictions bring their own label set; with `labels`, our own format must have the same one and COCO categories are mapped
// to it by name. Of how predictions are joined (SegmentationOptions) only keep_whole_classes can still be chosen: what lay behind
// the instances in front is not in the file. Throws Error naming the file that is missing, damaged or of another size than the
// frame.
std::unique_ptr<Predictor> make_file_predictor(const std::filesystem::path& path, const std::optional<LabelSet>& labels = {},
                                               bool keep_whole_classes = true);

}  // namespace panoptic
