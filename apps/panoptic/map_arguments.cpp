// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "apps/panoptic/map_arguments.h"

#include <fmt/format.h>

namespace panoptic {
namespace {

CLI::App* add_map_command(CLI::App& app, const char* name, const char* help, Arguments& a) {
  CLI::App* command = app.add_subcommand(name, help);
  command->add_option("map", a.map, "map file, as run --map writes it")->required();
  add_threads(*command, a);
  return command;
}

void add_single_maps(CLI::App& app, Arguments& a) {
  CLI::App* info = add_map_command(app, "info", "what a map file holds, or a bag (.bag, .mcap, .db3)", a);
  info->add_flag("--json", a.as_json, "as JSON");

  CLI::App* mesh = add_map_command(app, "mesh", "write the surface of a map file", a);
  mesh->add_option("-o,--output", a.output, "file that ends in .ply or .glb")->required();

  CLI::App* query = add_map_command(app, "query", "ask a map file where things are; without a question: all objects", a);
  query->add_option("--class", a.query_class, "objects of this class");
  query->add_option("--box", a.query_box, "objects in this box: x0,y0,z0,x1,y1,z1 in metres");
  query->add_option("--nearest", a.query_nearest, "the five objects nearest to x,y,z");
  query->add_option("--at", a.query_at, "what is at x,y,z");
  query->add_option("--when", a.query_when, "objects that were there at this time, seconds of the recording");
  query->add_option("--changes-since", a.query_since, "objects that came, were moved or went after this time");
  query->add_flag("--json", a.as_json, "as JSON");
  query->footer("Write --at=-1,2,3 where the first number is negative.");

  CLI::App* regularize = add_map_command(app, "regularize", "regularize the labels of a map file anew, in place", a);
  regularize->add_option("--set", a.settings, "one option, regularizer.key=value; may be repeated");

  CLI::App* rebuild = add_map_command(app, "rebuild", "make a map file anew with corrected poses, without networks", a);
  rebuild
      ->add_option("--poses", a.poses,
                   "trajectory: time x y z qx qy qz qw (TUM) or frame x y z qx qy qz qw, world from camera, for all frames or "
                   "some")
      ->required();
  rebuild->add_option("-o,--output", a.output, "the new map file; must not exist")->required();
  rebuild->add_option("--recording", a.dataset, "where the map's recording is now, if it has moved");
  rebuild->footer("Objects keep their ids; those that turn out to be one are merged (docs/maps.md).");
}

void add_plan(CLI::App& app, Arguments& a) {
  CLI::App* plan = add_map_command(app, "plan", "distances, grids, navigation meshes and ways for those who move in a map", a);
  plan->add_option("-o,--output", a.output, "folder for grid.pgm, esdf.npy, navmesh.glb, path.json ...")->required();
  CLI::Option* from = plan->add_option("--from", a.path_from, "where a way begins: x,y,z in metres, in the world of the map");
  CLI::Option* to = plan->add_option("--to", a.path_to, "where it ends: x,y,z, or a thing by the name of its node in scene.glb");
  from->needs(to);
  to->needs(from);
  const AgentSize usual;
  plan->add_option("--radius", a.agent.radius_m, fmt::format("of whoever moves, metres, default {}", usual.radius_m));
  plan->add_option("--height", a.agent.height_m, fmt::format("of whoever moves, metres, default {}", usual.height_m));
  plan->add_option("--climb", a.agent.climb_m, fmt::format("the highest step that it takes, metres, default {}", usual.climb_m));
  plan->add_option("--band", a.bands, "z0:z1, heights above the floor for a grid of their own; may be repeated");
  CLI::Option* agents = plan->add_option("--simulate-agents", a.agent_count,
                                         "people who live in the map for a while, 1 to 32: they walk, sit, lie (agents.json)");
  plan->add_option("--seconds", a.agents.seconds, fmt::format("of their time, default {:g}", a.agents.seconds))->needs(agents);
  plan->add_option("--seed", a.agents.seed, "which life they have; a whole number, default 1")->needs(agents);
  plan->add_option("--insects", a.agents.insects, "insects that crawl on the walls meanwhile, up to 32, default 0")
      ->needs(agents);
  plan->add_option("--json", a.agents.file, "file for what they did, default agents.json in the folder")->needs(agents);
  plan->footer("Write --from=-1,2,0 where the first number is negative. docs/planning.md describes the files.");
}

void add_alignment(CLI::App& command, Arguments& a) {
  command.add_flag(
      "--align", a.align,
      "find out how the other map lies by objects and surfaces, and bring it into the world of the first; without it "
      "both must lie in one world already");
}

void add_map_pairs(CLI::App& app, Arguments& a) {
  CLI::App* merge = add_map_command(app, "merge", "make one map file of two of the same place", a);
  merge->add_option("other", a.other_map, "map file with the same voxel size, truncation and label set")->required();
  merge->add_option("-o,--output", a.output, "map file to write; must not exist")->required();
  add_alignment(*merge, a);
  merge->footer("The result is a finished map: a run cannot go on from it (--resume).");

  CLI::App* diff = add_map_command(app, "diff", "what changed from one map file to another of the same place", a);
  diff->add_option("other", a.other_map, "the later map, with the same voxel size, truncation and label set")->required();
  diff->add_option("--json", a.json, "write the changes to this file");
  diff->add_option("--png", a.png, "draw both maps from above, with rings around what changed");
  add_alignment(*diff, a);
  diff->footer("Vanished and appeared: the other map saw that the place is empty. Otherwise: not seen.");
}

void add_export(CLI::App& app, Arguments& a) {
  const CLI::Range most(std::size_t{0}, std::size_t{1000});
  CLI::App* command = add_map_command(app, "export-web", "save the page with a map and its figures as a folder for the web", a);
  command->add_option("-o,--output", a.output, "folder; must be absent or empty")->required();
  command->add_option("--camera-frames", a.camera_frames, "frames of the recording for the camera view, default 40")->check(most);
}

}  // namespace

void add_threads(CLI::App& app, Arguments& a) {
  app.add_option("--threads", a.threads, "threads to use; 0 = one per core")->check(CLI::Range(0, 1024));
}

void add_map_commands(CLI::App& app, Arguments& a) {
  add_single_maps(app, a);
  add_map_pairs(app, a);
  add_plan(app, a);
  add_export(app, a);
}

}  // namespace panoptic
