// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/panoptic/arguments.h"
#include "apps/panoptic/map_arguments.h"
#include "apps/panoptic/take_topics.h"
#include "panoptic/base/config.h"
#include "panoptic/base/version.h"
#include "panoptic/mapping/option_fields.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <map>

namespace panoptic {
namespace {

constexpr const char* kFooter =
    "Examples:\n"
    "  panoptic run kitchen/ --calibration kitchen.toml --semantic enet.toml --instance yolo.toml -o out/kitchen\n"
    "  panoptic run scan.sens --predictions predictions/ -o out/scan --set map.voxel_size_m=0.01\n"
    "  panoptic doctor recording/\n"
    "  panoptic check-network yolo.onnx picture.jpg --png seen.png --write yolo.toml\n"
    "  panoptic simulate --seed 1 -o home && panoptic run home --predictions home/predictions -o out/home\n"
    "  panoptic view out/kitchen\n"
    "  panoptic explain out/kitchen 44 --png chair_44.png\n"
    "  panoptic eval out/home --gt home --json scores.json\n"
    "Exit codes: 0 done, 1 something in the world is wrong (one line on stderr), 2 wrong usage, 130 interrupted.";

void add_recording(CLI::App& app, Arguments& a) {
  app.add_option("dataset", a.dataset,
                 "recording: ScanNet .sens or export, 7-Scenes, 3DMatch, TUM RGB-D, Replica, a bag (.bag, .mcap, .db3), or a "
                 "plain folder;\n"
                 "a list of recordings, LIST.toml, to map them as one; or a simulated home: "
                 "sim:SEED[,rooms=R,frames=F,noise=P,\ndynamics=D,jumps=N]")
      ->required();
  app.add_option("--calibration", a.calibration, "TOML file that overrides intrinsics, lens, depth scale and the colour camera");
  app.add_option(
         "--pair-tolerance", a.pair_tolerance_s,
         "seconds between colour and depth of a pair at most, for recordings paired by time (TUM RGB-D, bags), default 0.02")
      ->check(CLI::Range(0.0, 1e6));
  app.add_option(
      "--topics", a.topics,
      "of a bag: depth=TOPIC,color=TOPIC,info=TOPIC,pose=TOPIC, each where there are several (panoptic info BAG lists them)");
  add_threads(app, a);
}

void add_preflight(CLI::App& app, Arguments& a) {
  app.add_flag("--no-preflight", a.no_preflight, "do not look for impossible and unlikely numbers of the recording first");
}

void add_networks(CLI::App& app, Arguments& a) {
  app.add_option("--semantic", a.semantic,
                 "model description (TOML) of a semantic network; may be repeated: the class probabilities are averaged");
  app.add_option("--instance", a.instance, "model description (TOML) of the instance network");
  app.add_option("--labels", a.labels,
                 "label set: indoor, home, scannet20 or a TOML file; default: the predictions' own, else indoor");
  app.add_option("--preset", a.preset,
                 fmt::format("options to start from: {} (best measured), {}", kDefaultPreset, preset_names()));
  app.add_option("--config", a.config, "TOML file of options; out/options.toml of an earlier run is one");
  app.add_option("--set", a.settings, "one option, key=value; may be repeated (keys: panoptic options)");
  app.add_option("--frames", a.frames, "A:B or A:B:STEP, positions in the sequence from 0, B excluded");
}

void add_simulation(CLI::App& app, Arguments& a) {
  constexpr int kMostRooms = 8;
  constexpr int kMostFrames = 1000000;
  app.add_option("--seed", a.seed, "which home; a whole number, default 1");
  app.add_option("--rooms", a.rooms, "rooms of the home, default 4")->check(CLI::Range(1, kMostRooms));
  app.add_option("--frames", a.frame_count, "frames of the recording; default: as the way takes at 30 Hz")
      ->check(CLI::Range(1, kMostFrames));
  app.add_option("--noise", a.noise, "sensor and tracker: none, kinect (default), drift, harsh");
  app.add_option("--dynamics", a.dynamics, "what moves: static (default), people, changes (furniture and doors), busy (both)");
  app.add_option("--jumps", a.jumps, "how often the camera is carried to another place, nothing seen on the way; default 0");
  app.add_option("--predictions", a.predictions, "what networks give: oracle, good, maskrcnn (default), poor, or none");
  app.add_option("--config", a.config, "TOML file of options; DIR/simulation.toml of an earlier simulation is one");
  app.add_option("--set", a.settings, "one option, key=value, as in simulation.toml; may be repeated");
  add_threads(app, a);
  CLI::Option* output = app.add_option("-o,--output", a.output, "folder for the scan; must be absent or empty");
  app.add_option("--contact-sheet", a.contact_sheet, "instead of a scan: a PNG that shows the home and the five after it")
      ->excludes(output);
  app.footer("Writes a ScanNet scan: recording, true mesh, 2D labels, and predictions to map it with (docs/simulator.md).");
}

void add_evaluation(CLI::App& app, Arguments& a) {
  app.add_option("out", a.evaluated,
                 "folder of a run, or a map file; or semantic, instance or panoptic, for --pred in ScanNet's submission forms")
      ->required();
  app.add_option(
         "--gt", a.truth,
         "a ScanNet scan, or the simulated home that was mapped, sim:SEED...; with --pred a folder of <scene>.txt or of scans")
      ->required();
  app.add_option("--pred", a.predictions, "folder of <scene>.txt, of any method");
  app.add_option("--json", a.json, "write the scores to this file");
  app.add_option("--csv", a.csv, "write the scores per class to this file");
  app.add_option("--write-submission", a.submission,
                 "write the labels as the ScanNet server takes them, and the truth, to this folder");
  CLI::Option* changes =
      app.add_flag("--changes", a.changes,
                   "score too what the run says is gone, new and moved, and ghosts; --gt is a scan of simulate --dynamics");
  app.add_option("--moving", a.moving, "with --changes: score the masks in this folder, written by run --write-moving")
      ->needs(changes);
  app.add_option("--category-map", a.category_map, "scannetv2-labels.combined.tsv; default: beside the scan, else NYU40's names");
  app.add_option("--id-space", a.id_space,
                 "how --pred numbers classes: nyu40 (default), scannet20 (1 to 20 in the benchmark's order), train (0 to 19)");
  app.add_option("--variant", a.variant, "panoptic quality: pq-scannet20 (default), seed, ndt, coco");
  add_threads(app, a);
  app.footer("Semantic IoU, instance AP, panoptic quality and surface distances; the rules are in docs/evaluation.md.");
}

void add_trajectory_evaluation(CLI::App& app, Arguments& a) {
  app.add_option("estimate", a.trajectory, "trajectory (`time tx ty tz qx qy qz qw` a line), or the folder of a run")->required();
  app.add_option("truth", a.true_trajectory, "the same of the truth, or a folder with groundtruth.txt")->required();
  app.add_option("--json", a.json, "write the scores to this file");
  app.add_option("--pair-tolerance", a.pair_tolerance_s, "seconds between the stamps of a pair at most, default 0.02")
      ->check(CLI::Range(0.0, 1e6));
  app.add_option("--rpe-step", a.rpe_step_s, "seconds over which the relative error is taken, default 1")
      ->check(CLI::Range(1e-3, 1e6));
  app.footer("ATE (rigid alignment, no scale) and RPE as the tools of the TUM RGB-D benchmark define them (docs/tracking.md).");
}

void add_explanation(CLI::App& app, Arguments& a) {
  app.add_option("out", a.explained, "folder of a run")->required();
  app.add_option("id", a.object_id, "panoptic id of an object, as in objects.json and in the pictures")->required();
  app.add_option("--png", a.png, "draw its best frames and where it is in the map; needs the run's recording");
  app.footer("Probabilities, votes over time, best frames, boxes, mergers: docs/outputs.md says what each means.");
}

void add_viewer(CLI::App& app, Arguments& a) {
  constexpr int kMostPorts = 65535;
  app.add_option("--port", a.port, "port of the viewer; default: 8060, or the next one that is free; 0: any")
      ->check(CLI::Range(0, kMostPorts));
  app.add_option("--bind", a.bind, "address of the viewer; default 127.0.0.1; others than loopback need --token");
  app.add_option("--token", a.token, "what browsers must show: 8 to 128 characters of A-Z a-z 0-9 - . _ ~");
}

void add_map_file(CLI::App& run, Arguments& a) {
  constexpr double kLongest_s = 1e6;
  CLI::Option* map = run.add_option("--map", a.map, "map file to save to, every few seconds and at the end; must not exist");
  run.add_flag("--resume", a.resume, "go on from the map file, if it exists; not with --online")->needs(map);
  run.add_option("--in", a.earlier_map,
                 "saved map of the same place, of an earlier run --map: the recording is a further visit (docs/moving.md)")
      ->needs(map);
  run.add_flag("--track", a.track,
               "find out where the camera is, online too; the recording's poses are not used (docs/tracking.md)");
  run.add_option(
      "--pose-updates", a.pose_updates,
      "corrections of poses by the SLAM system, a line of JSON for each moment (docs/maps.md); the map follows, online too");
  run.add_option("--checkpoint-every", a.checkpoint_every_s, "seconds from one save to the next, default 5")
      ->check(CLI::Range(0.0, kLongest_s))
      ->needs(map);
}

void add_live(CLI::App& run, Arguments& a) {
  CLI::Option* online =
      run.add_flag("--online", a.online, "map as with a camera: labels when they are ready, frames dropped when behind");
  const std::map<std::string, double> words = {{"max", 0}};
  run.add_option("--speed", a.speed,
                 "with --online: times the speed of the recording, default 1; max: as fast as it can be mapped")
      ->transform(CLI::Transformer(words))
      ->check(CLI::Range(0.0, 1000.0))
      ->needs(online);
  run.add_flag("--view", a.view, "show the map in the browser while it grows");
  add_viewer(run, a);
}

void add_run(CLI::App& run, Arguments& a) {
  add_recording(run, a);
  add_preflight(run, a);
  add_networks(run, a);
  run.add_option("--predictions", a.predictions, "use the predictions in this folder instead of networks");
  run.add_option("-o,--output", a.output, "folder for mesh.ply, scene.glb, objects.json, report.json, views/")->required();
  run.add_option("--write-moving", a.write_moving, "folder for a mask of what moves in each frame: 8 bits, 255 = moves");
  run.add_flag("--no-pictures", a.no_pictures, "leave out views/: no pictures of the map");
  add_map_file(run, a);
  add_live(run, a);
  run.footer("Without networks and predictions, geometry and colour are mapped.");
}

void add_prediction(CLI::App& predict, Arguments& a) {
  add_recording(predict, a);
  add_preflight(predict, a);
  add_networks(predict, a);
  predict.add_option("-o,--output", a.output, "folder for the predictions")->required();
}

void add_doctor(CLI::App& doctor, Arguments& a) {
  add_recording(doctor, a);
  doctor.add_flag("--json", a.as_json, "as JSON");
}

void add_network_check(CLI::App& check, Arguments& a) {
  check.add_option("network", a.network, "model description (TOML), or an ONNX file alone")->required();
  check.add_option("image", a.image, "picture to look at; without one, noise: it shows shapes, and whether the network runs");
  check.add_option("--labels", a.labels, "label set: indoor, home, scannet20 or a TOML file; default: indoor");
  check.add_option("--engine", a.engine, "inference engine: auto, onnxruntime, opencv");
  check.add_option("--json", a.json, "write what was found out to this file");
  check.add_option("--png", a.png, "draw what the network saw into this picture");
  check.add_option("--write", a.written_description, "write a model description to start from into this file");
  add_threads(check, a);
}

void add_view(CLI::App& view, Arguments& a) {
  view.add_option("out", a.viewed, "folder of a run, or a map file")->required();
  add_viewer(view, a);
}

void add_play(CLI::App& play, Arguments& a) {
  play.add_option("map", a.viewed, "map file, as run --map writes it")->required();
  add_viewer(play, a);
}

void add_jobs(CLI::App& app, Arguments& a, const std::string& what) {
  constexpr int kMostJobs = 4096;
  app.add_option("--jobs", a.jobs, what + " at a time, each in a process of its own, default 1")->check(CLI::Range(1, kMostJobs));
}

void add_benchmark(CLI::App& benchmark, Arguments& a) {
  benchmark.add_flag("--quick", a.quick, "one small home and few settings, in two minutes; fails if a score is below its floor");
  benchmark.add_option("--group", a.group,
                       "answer this question alone, named as the report names it: 'Regularizer', 'Voxel size' ...");
  benchmark.add_option("-o,--output", a.output, "folder for report.md, report.json, charts; it goes on from there")->required();
  add_jobs(benchmark, a, "parts (a home under a few settings)");
  benchmark.add_option("--part", a.benchmark_part, "what a benchmark calls")->group("");
  add_threads(benchmark, a);
}

void add_batch(CLI::App& batch, Arguments& a) {
  batch.add_option("list", a.dataset, "file with a recording or sim:SEED a line, or a folder of recordings")->required();
  batch.add_option("-o,--output", a.output, "folder for batch.json, batch.md and a folder for each scene")->required();
  add_jobs(batch, a, "scenes");
  batch.add_flag("--gt", a.with_truth, "score each scene against its truth, and all of them together");
  batch.add_option(
      "--share-predictions", a.shared_predictions,
      "folder that keeps the predictions of each scene, made once by --semantic and --instance, for other batches too");
  CLI::Option* slurm =
      batch.add_flag("--slurm", a.slurm, "submit the scenes to Slurm instead; --jobs: at most so many at a time");
  batch.add_option("--slurm-option", a.slurm_options, "for sbatch, like --slurm-option=--mem=16G; may be repeated")->needs(slurm);
  batch.add_option("--task", a.slurm_task, "what a submitted batch calls")->group("");
  batch.add_flag("--gather", a.slurm_gather, "what a submitted batch calls at its end")->group("");
  batch.footer(
      "What comes after -- are options of panoptic run; in them {} is the scene's path and {name} its name:\n"
      "  panoptic batch scans/ -o out --jobs 4 --gt -- --predictions {}/predictions --no-pictures\n"
      "What is finished is skipped, also after a crash (docs/batch.md).");
}

// In a batch the words after -- are for `panoptic run`, and parsed as its arguments are.
int cut_run_options(int argc, char** argv, Arguments& a) {
  if (argc < 2 || std::string(argv[1]) != "batch") return argc;
  char** const end = argv + argc;
  char** const dashes = std::find(argv, end, std::string("--"));
  if (dashes != end) a.run_options.assign(dashes + 1, end);
  return static_cast<int>(dashes - argv);
}

}  // namespace

Arguments parse_arguments(int argc, char** argv) {
  Arguments a;
  CLI::App app("PanopticFusion: posed RGB-D frames in, a 3D map that knows what everything is and which one it is out.",
               "panoptic");
  app.set_version_flag("--version", fmt::format("panoptic {}", version()));
  app.footer(kFooter);
  app.require_subcommand(1);
  add_run(*app.add_subcommand("run", "map a recording"), a);
  add_prediction(*app.add_subcommand("predict", "run the networks over a recording and write their predictions to disk"), a);
  add_doctor(*app.add_subcommand("doctor", "check a recording: depth scale, poses, intrinsics, dropped frames"), a);
  add_network_check(*app.add_subcommand("check-network", "run a network once and say what its outputs are taken for"), a);
  add_evaluation(*app.add_subcommand("eval", "score a run, or a submission, against ScanNet-style ground truth"), a);
  add_map_commands(app, a);
  add_trajectory_evaluation(*app.add_subcommand("eval-trajectory", "how far a trajectory is from the true one: ATE and RPE"), a);
  add_explanation(*app.add_subcommand("explain", "why an object of a map is what it is said to be"), a);
  add_view(*app.add_subcommand("view", "look at a finished map in the browser"), a);
  add_play(*app.add_subcommand("play", "let figures walk, sit and lie in a map, in the browser"), a);
  add_simulation(*app.add_subcommand("simulate", "make a furnished home, film it, and write it as a ScanNet scan"), a);
  add_batch(*app.add_subcommand("batch", "map many recordings, one after the other, beside each other or on a cluster"), a);
  add_benchmark(*app.add_subcommand("benchmark", "map simulated homes under many settings and write a report with charts"), a);
  app.add_subcommand("options", "list every option with its default, range and meaning");

  try {
    app.parse(cut_run_options(argc, argv, a), argv);
  } catch (const CLI::Success& e) {
    app.exit(e);
    return a;
  } catch (const CLI::ParseError& e) {
    throw UsageError(fmt::format("{}; see panoptic --help", e.what()));
  }
  a.command = app.get_subcommands().front()->get_name();
  take_topics(a);
  return a;
}

Options options_from(const Arguments& a) {
  if (!a.predictions.empty() && !(a.semantic.empty() && a.instance.empty())) {
    throw UsageError("--predictions stands for networks: leave out either it or --semantic and --instance");
  }
  Options options = preset_options(a.preset.empty() ? kDefaultPreset : a.preset);
  if (!a.config.empty()) read_toml_file(a.config, fields(options));
  // The source of labels is one choice: a flag for one way wins over the other way in the file.
  if (!a.predictions.empty()) {
    options.networks.semantic.clear();
    options.networks.instance.clear();
  }
  if (!a.semantic.empty() || !a.instance.empty()) options.predictions.clear();
  const Fields all = fields(options);
  for (const std::string& setting : a.settings) {
    try {
      set_field(all, setting);
    } catch (const Error& e) {
      throw UsageError(e.what());
    }
  }
  if (!a.semantic.empty()) options.networks.semantic = a.semantic;
  if (!a.instance.empty()) options.networks.instance = a.instance;
  if (!a.predictions.empty()) options.predictions = a.predictions;
  if (!a.labels.empty()) options.labels = a.labels;
  return options;
}

}  // namespace panoptic
