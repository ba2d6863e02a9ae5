// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Every option of the program; the defaults are here and nowhere else. `panoptic options` lists them with their ranges.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace panoptic {

// The fusion of what networks see in one frame (segmentation.h, Eq. 1).
struct SegmentationOptions {
  bool keep_whole_classes = true;  // false: a semantic thing pixel without an instance is unknown (the paper)
  bool smaller_in_front = true;    // false: the higher score is in front (the paper)
};

// The networks (predictor.h).
struct NetworkOptions {
  std::vector<std::string> semantic;      // model descriptions (TOML), their class probabilities are averaged; empty = no stuff
  std::string instance;                   // model description (TOML); empty = no things
  std::string engine = "auto";            // or "onnxruntime", "opencv"
  int threads = 0;                        // of inference; 0 = as many as everything else
  std::optional<double> score_threshold;  // instead of the one in the instance network's description
  // Takes the likeliest of a network's own classes, then its counterpart in the label set (the paper). False: the probabilities
  // of network classes that are the same in the label set are added first.
  bool likeliest_first = false;
  float unknown_share = 0.7F;  // what counts of the probability of network classes that the label set lacks; 1 in the paper
  SegmentationOptions segmentation;
};

// Depth readings.
struct DepthOptions {
  float min_m = 0.1F;  // readings outside [min, max] are taken as missing
  float max_m = 8;
};

// The voxels (voxel_map.h).
struct MapOptions {
  float voxel_size_m = 0.024F;
  float truncation_voxels = 4;  // half width of the band in which voxels are updated
  // The limit of W^D and W^V of a voxel, in 1/m^2; 0 = none. A voxel at the limit forgets: what is seen from then on outweighs
  // all before it after ln 2 * max_weight / w frames, where w = 1/z^2 (for labels times the vote). Those are 6,900 frames at 1 m,
  // 620 at 0.3 m and 170,000 at 5 m; colours change no later. With cast rays a voxel is counted once per ray.
  float max_weight = 10000;
  // Keeps in cells of 4 voxels what was seen to be empty (free_space.h). The paper has nothing of the kind.
  bool free_space = true;
  int memory_limit_mb = 0;  // of 1e6 bytes; 0 = none
  // The folder of the file that holds what is beyond the limit; empty = the system's for temporary files (`panoptic run`: the
  // output folder).
  std::string swap_folder;
  // "reference": poses and labels of all used frames are kept, so that the map can follow corrected poses (Mapper::update_poses);
  // depth and colour are read again from the recording. "copy": those are kept, too, without loss; with a map file they lie
  // there, and not in memory. "none": nothing is kept. "auto": "reference" in a `panoptic run` with --map or --pose-updates, else
  // "none".
  std::string log = "auto";
  int log_limit_mb = 1000;  // in memory, of 1e6 bytes; a map whose log grew beyond this cannot follow any more
  // A frame whose pose is corrected by less keeps its pose: what a point 2 m before the camera moves at most.
  float pose_tolerance_m = 0.002F;
};

// Objects from frame to frame (Eq. 3-5).
struct TrackerOptions {
  float iou_threshold = 0.25F;  // theta_U in Eq. 4
  // A pixel that says less than the map knows votes for what the map holds there: a pixel of unknown or a table for a thing
  // without a class, a pixel of a class without an instance for a thing of that class. False in the paper.
  bool trust_map = true;
};

// Frames into voxels (Eq. 6-11).
struct IntegratorOptions {
  // "projective": every voxel near the surface looks up the pixel it projects to. "raycast": every pixel updates the voxels
  // along its ray, as in the paper. Same weights, same label rule; raycast counts a voxel once per ray through it.
  std::string method = "projective";
  // The votes of an object's pixel for its label (Eq. 9-11), where other pixels have 1: detectors miss things in many frames.
  // The paper has 1.
  float object_vote = 4;
  // With "projective": across a surface the band reaches two voxels at least, however flat the view (fusion/grazing.h).
  bool grazing = true;
};

// Carving: what the camera looks through is cleared from the map. The paper has nothing of the kind. It needs map.free_space.
struct CarvingOptions {
  bool enabled = true;
  int views = 5;  // that must look through a voxel, each from another place, and none sees a surface there meanwhile
};

// Things that move, and things that are moved. The paper has nothing of the kind. `points` and `objects` need map.free_space.
struct MovingOptions {
  bool classes = true;  // things of a mobile class (label set) are kept out of the map
  bool points = true;   // what comes into space that is known to be free is kept out of the map while it moves
  bool objects = true;  // what was looked through is gone, and what came or was moved is known
};

// Object maintenance, which the paper has none of; docs/accuracy.md says what each rule gains.
struct MaintenanceOptions {
  bool enabled = true;
  int every_frames = 20;
  // Two objects of one class are one if this share of the smaller one is this near to the larger one, unless they were seen as
  // two masks in this share of the frames of the one seen less.
  float merge_share = 0.2F;
  float merge_distance_m = 0.07F;
  float together_share = 0.2F;
  bool carve = true;             // things on tables are things of their own, also where no network knows them
  float carve_height_m = 0.02F;  // above the table top
  // At the end:
  float floor_height_m = 0.03F;  // level surface this near to the floor's plane is floor; 0 = as the networks say
  // Objects seen in fewer frames are dropped. Of fewer than 210 labelled frames one in every 35 is enough, rounded up.
  int min_observations = 6;
  // Fewer are enough where it is as probable that any of the detections was right, each being right by its score.
  float min_certainty = 0.8F;
  float min_thing_m2 = 0.05F;   // unnamed things with less surface are dropped
  float min_region_m2 = 0.12F;  // unknown regions from this surface on are things
  float stray_share = 0.15F;    // pieces of an object smaller than this share of its largest piece are dropped
  float size_margin = 1.15F;    // an object this much longer than its class can be (label set, max_size_m) is of another class
};

// The paper's w1, w2 are 10 and 15 and it regularizes every voxel (configs/presets/paper.toml); on real recordings that
// loses small objects, see docs/decisions/0008-crf.md.
struct RegularizerOptions {
  bool enabled = true;
  int every_frames = 300;             // used frames between two runs: 10 s at 30 Hz
  float w1 = 4;                       // weight of the kernel over place and colour (Eq. 15)
  float w2 = 4;                       // weight of the kernel over place alone
  float theta_alpha_m = 0.05F;        // reach of both kernels in space
  float theta_beta = 20;              // reach in colour, of 255
  int iterations = 5;                 // of the mean field
  int max_blocks = 25;                // of a tile, which is regularized at once; 0 = the whole map
  float band_voxels = 1.5F;           // half width of the band around the surface that is regularized
  float highest_probability = 0.99F;  // of a label, however sure its votes are (Eq. 19)
};

// The surface.
struct MesherOptions {
  float min_weight = 1e-4F;  // voxels observed with less W^D (1/m^2) are taken as unseen
};

// Mapping while frames arrive (docs/online.md).
struct OnlineOptions {
  float mesh_every_s = 1;
  float regularize_every_s = 10;
  int waiting_frames = 15;  // between reading and fusion: half a second at 30 Hz
};

struct Options {
  std::string labels;       // label set: a built-in name or a TOML file; empty = the predictions' own, else "indoor"
  std::string predictions;  // folder of predictions to use instead of networks; empty = none
  NetworkOptions networks;
  DepthOptions depth;
  MapOptions map;
  TrackerOptions tracker;
  IntegratorOptions integrator;
  CarvingOptions carving;
  MovingOptions moving;
  MaintenanceOptions objects;
  RegularizerOptions regularizer;
  MesherOptions mesher;
  OnlineOptions online;
};

inline constexpr const char* kDefaultPreset = "default";

// The defaults with what the preset changes: kDefaultPreset changes nothing, "paper" follows the paper to the letter; the files
// in configs/presets. Throws Error naming the presets there are.
Options preset_options(const std::string& name);
std::string preset_names();  // those beside the default

// The defaults with what the TOML file changes. Throws Error naming file, line and remedy.
Options load_options(const std::filesystem::path& path);

// One option by its name, "map.voxel_size_m=0.05"; a bare word is taken as a string. Throws Error: no such option, or no such
// value.
void set_option(Options& options, const std::string& assignment);

}  // namespace panoptic
