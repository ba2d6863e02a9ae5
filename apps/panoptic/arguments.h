// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The command line.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "panoptic/error.h"
#include "panoptic/options.h"
#include "panoptic/planning.h"

namespace panoptic {

// Exit codes that scripts may rely on.
enum ExitCode : int { kDone = 0, kWorldIsWrong = 1, kWrongUsage = 2, kInterrupted = 130 };

// A mistake in the command line, as opposed to something wrong in the world.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Arguments {
  std::string command;  // "run", "predict", "doctor"; empty when only help or the version was asked for
  std::string dataset;
  std::string output;
  std::string preset;
  std::string config;
  std::vector<std::string> settings;  // key=value
  std::string calibration;
  std::optional<double> pair_tolerance_s;
  std::string topics;         // of a bag; parse_arguments appends them to `dataset`
  bool no_preflight = false;  // run, predict
  std::vector<std::string> semantic;
  std::string instance;
  std::string predictions;
  std::string labels;
  std::string frames;
  int threads = 0;
  // run
  bool online = false;
  bool no_pictures = false;
  std::optional<double> speed;  // 0 = as fast as possible
  bool view = false;
  std::string map;          // map file: to keep up to date, or to look at
  std::string other_map;    // merge, diff: the second one
  bool align = false;       // merge, diff: bring the other map into the world of the first
  std::string earlier_map;  // --in
  bool resume = false;
  std::string pose_updates;
  bool track = false;
  std::string poses;  // rebuild
  // eval-trajectory
  std::string trajectory;
  std::string true_trajectory;
  double rpe_step_s = 1;
  std::optional<double> checkpoint_every_s;
  // simulate
  std::optional<std::string> seed;
  std::optional<int> rooms;
  std::optional<int> frame_count;
  std::optional<int> jumps;
  std::optional<std::string> noise;
  std::optional<std::string> dynamics;
  std::string contact_sheet;
  // eval
  std::string evaluated;  // folder of a run, or "semantic", "instance", "panoptic": the form of `predictions`
  std::string truth;
  std::string json;
  std::string csv;
  std::string submission;
  bool changes = false;
  std::string moving;
  std::string category_map;
  std::string id_space = "nyu40";
  std::string variant = "pq-scannet20";
  // explain
  std::string explained;  // folder of a run
  std::uint32_t object_id = 0;
  std::string png;
  // check-network
  std::string network;  // model description, or ONNX file
  std::string image;    // empty = grey noise
  std::string written_description;
  std::string engine = "auto";
  // view, and run --view
  std::string viewed;  // folder of a run
  std::string bind;    // empty = loopback
  std::optional<std::uint16_t> port;
  std::string token;
  std::size_t camera_frames = 40;  // export-web
  // query, info
  std::string query_class;
  std::string query_box;
  std::string query_nearest;
  std::string query_at;
  std::optional<double> query_when;  // seconds of the recording
  std::optional<double> query_since;
  std::string write_moving;  // run: folder
  bool as_json = false;
  // plan
  std::string path_from;
  std::string path_to;
  std::vector<std::string> bands;
  AgentSize agent;
  std::optional<int> agent_count;
  AgentOptions agents;
  // batch; its list is `dataset`
  std::optional<int> jobs;  // 1, and with Slurm as many as it likes
  bool with_truth = false;
  std::string shared_predictions;
  bool slurm = false;
  std::vector<std::string> slurm_options;
  std::optional<std::size_t> slurm_task;  // the number of a scene that was submitted
  bool slurm_gather = false;
  std::vector<std::string> run_options;  // after --
  // benchmark
  bool quick = false;
  std::string group;
  std::optional<std::size_t> benchmark_part;  // the number of one that is run in a process of its own
};

// Prints help or the version when asked. Throws UsageError.
Arguments parse_arguments(int argc, char** argv);

// Options from the preset, then --config, then --set, then the flags of their own; --predictions on the one side, --semantic
// and --instance on the other, also win over what the file says about the other side. Throws UsageError for --set and for flags
// that exclude each other, Error for the preset and the file.
Options options_from(const Arguments& arguments);

}  // namespace panoptic
