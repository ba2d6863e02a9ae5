// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Predictions and ground truth as text files in ScanNet's submission forms, one <scene>.txt per scene:
//   semantic   a NYU40 id per vertex
//   instance   lines "mask_path label_id confidence" and mask files with a number per vertex, nonzero = member; its ground truth
//              is class * 1000 + instance per vertex
//   panoptic   class * 1000 + instance per vertex, for both (ours; ScanNet has none)
// All functions throw Error naming file and line.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "panoptic/eval/id_space.h"
#include "panoptic/evaluation.h"

namespace panoptic {

enum class SubmissionForm { kSemantic, kInstance, kPanoptic };

// The scenes that have a <scene>.txt in the folder, sorted. The evaluators' own results (semantic_label_evaluation.txt,
// semantic_instance_evaluation.txt) are no scenes. Throws if there is none.
std::vector<std::string> scenes_in(const std::filesystem::path& folder);

// Numbers outside the classes that can be are kUnknown. `space`: how the classes are numbered.
std::vector<ClassId> read_semantic(const std::filesystem::path& path, IdSpace space = IdSpace::kNyu40);
VertexLabels read_panoptic(const std::filesystem::path& path, IdSpace space = IdSpace::kNyu40);

// The masks of <scene>.txt. If two lines name one mask file, the later one counts, in the place of the first. Refuses paths
// that are absolute or leave the folder, and masks that have not one number per vertex.
std::vector<InstanceMask> read_instances(const std::filesystem::path& folder, const std::string& scene, std::size_t vertices,
                                         IdSpace space = IdSpace::kNyu40);

// The truth of a scene: <scene>.txt in the folder, in the truth's form, or a ScanNet scan in folder/<scene>.
VertexLabels read_truth(const std::filesystem::path& folder, const std::string& scene, SubmissionForm form,
                        const std::filesystem::path& category_map = {});

// Adds a scene to folder/{semantic,instance,panoptic}: the files that the ScanNet server takes, and the panoptic form. Things
// get new instance numbers from 1 within their class. Masks too small to count are left out. `truth`, the scene's ground truth,
// goes to folder/truth in the same forms.
void write_submission(const std::filesystem::path& folder, const std::string& scene, const LabelledVertices& prediction,
                      const VertexLabels& truth);

}  // namespace panoptic
