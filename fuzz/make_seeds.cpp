// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Writes inputs to start from, made by the product's own writers: fuzz_make_seeds FOLDER gives FOLDER/<target>/<name>.
#include <fmt/format.h>

#include <cstdio>

#include "fuzz/input.h"
#include "fuzz/seeds.h"
#include "fuzz/small_bag.h"
#include "fuzz/small_map.h"
#include "panoptic/base/config.h"
#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/base/json.h"
#include "panoptic/io/scannet_scan.h"
#include "panoptic/io/sens_writer.h"
#include "panoptic/map/frame_images.h"
#include "panoptic/map/frame_log.h"
#include "panoptic/map/option_fields.h"
#include "panoptic/mapfile/block_codec.h"
#include "panoptic/outputs.h"
#include "panoptic/predict/prediction_io.h"
#include "panoptic/profile.h"
#include "tests/io/small_video.h"

namespace panoptic::fuzz {
namespace {

namespace fs = std::filesystem;
using std::string_literals::operator""s;        // NOLINT(misc-unused-using-decls): literals use it
using std::string_view_literals::operator""sv;  // NOLINT(misc-unused-using-decls)

template <typename Bytes>
std::string text(const Bytes& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Image<Rgb> some_colors(int width, int height) {
  Image<Rgb> image(width, height);
  for (std::size_t i = 0; i < image.size(); ++i)
    image[i] = {static_cast<std::uint8_t>(i * 5), static_cast<std::uint8_t>(i * 3), 90};
  return image;
}

Image<std::uint16_t> some_numbers(int width, int height) {
  Image<std::uint16_t> image(width, height);
  for (std::size_t i = 0; i < image.size(); ++i) image[i] = static_cast<std::uint16_t>(i % 3);
  return image;
}

std::string png(const Scratch& scratch, const Image<Rgb>& image) {
  write_png(scratch.path() / "a.png", image);
  return read_file(scratch.path() / "a.png");
}

void sens_seeds(Seeds& seeds, const Scratch& scratch) {
  Frame frame;
  frame.depth_camera = frame.color_camera = {8, 6, 7, 7, 3.5, 2.5};
  frame.depth = Image<float>(8, 6, 1.5F);
  frame.color = some_colors(8, 6);
  SensWriter writer(scratch.path() / "a.sens", frame.depth_camera);
  for (int i = 0; i < 2; ++i) {
    frame.index = i;
    frame.time_s = 0.1 * i;
    writer.write(encode_sens_frame(frame, 60));
  }
  writer.finish();
  std::string bytes = read_file(scratch.path() / "a.sens");
  seeds.put("sens", "two_frames", bytes);
  const std::size_t compression_at = bytes.size() > 300 ? bytes.find("\x02\0\0\0\x01\0\0\0"sv) : std::string::npos;
  if (compression_at == std::string::npos) return;
  bytes[compression_at] = 0;  // raw colour
  seeds.put("sens", "raw_color", bytes);
  bytes[compression_at] = 1;  // PNG
  bytes[compression_at + 4] = 0;
  seeds.put("sens", "raw_depth", bytes);
}

void image_seeds(Seeds& seeds, const Scratch& scratch) {
  seeds.put("image", "color.png", png(scratch, some_colors(9, 7)));
  seeds.put("image", "color.jpg", text(encode_jpeg(some_colors(17, 9), 50)));
  seeds.put("image", "gray8.png", text(encode_png(Image<std::uint8_t>(9, 7, 3))));
  seeds.put("image", "gray16.png", text(encode_png(some_numbers(9, 7))));
  seeds.put("image", "alpha.png", text(encode_png(some_colors(5, 4), Image<std::uint8_t>(5, 4, 100))));
  seeds.put("image", "gray16.pgm", "P5\n# a comment\n2 2\n65535\n\1\2\3\4\5\6\7\10"sv);
  seeds.put("image", "text.ppm", "P3 1 2 255 1 2 3 4 5 6\n"sv);
  std::string tiff = "II*\0\10\0\0\0\12\0"s;  // one strip of 2 x 1 floats
  const auto entry = [&](int tag, int type, int value) {
    for (const int word : {tag, type, 1, 0, value, 0}) tiff += {static_cast<char>(word), static_cast<char>(word >> 8)};
  };
  constexpr int kDataAt = 8 + 2 + 10 * 12 + 4;
  const int entries[][3] = {{256, 3, 2},       {257, 3, 1}, {258, 3, 32}, {259, 3, 1}, {262, 3, 1},
                            {273, 4, kDataAt}, {277, 3, 1}, {278, 3, 1},  {279, 4, 8}, {339, 3, 3}};
  for (const auto& [tag, type, value] : entries) entry(tag, type, value);
  tiff += std::string(4, '\0') + "\0\0\200\77\0\0\0\100"s;
  seeds.put("image", "float.tiff", tiff);
}

void depth_seeds(Seeds& seeds) {
  std::string npy = "\x93NUMPY\1\0\x46\0{'descr': '<f4', 'fortran_order': False, 'shape': (1, 2), }"s;
  npy.resize(79, ' ');
  seeds.put("image", "depth.npy", npy + "\n\0\0\200\77\0\0\0\100"s);
  const std::string window = "\0\0\0\0\0\0\0\0\1\0\0\0\0\0\0\0"s;  // 2 x 1 pixels
  const auto attribute = [](const char* name, const char* type, const std::string& value) {
    std::string bytes = name + "\0"s + type + "\0"s;
    bytes += static_cast<char>(value.size());
    return bytes + "\0\0\0"s + value;
  };
  std::string exr = "\x76\x2F\x31\1\2\0\0\0"s;
  exr += attribute("channels", "chlist", "Z\0\2\0\0\0\0\0\0\0\1\0\0\0\1\0\0\0\0"s);
  exr += attribute("compression", "compression", "\0"s) + attribute("dataWindow", "box2i", window);
  exr += attribute("displayWindow", "box2i", window) + attribute("lineOrder", "lineOrder", "\0"s);
  exr += attribute("pixelAspectRatio", "float", "\0\0\200\77"s) + attribute("screenWindowCenter", "v2f", std::string(8, '\0'));
  exr += attribute("screenWindowWidth", "float", "\0\0\200\77"s) + "\0"s;
  const std::size_t offset = exr.size() + 8;  // of the only line
  exr += std::string{static_cast<char>(offset), static_cast<char>(offset >> 8)} + std::string(6, '\0') +
         "\0\0\0\0\10\0\0\0\0\0\200\77\0\0\0\100"s;
  seeds.put("image", "depth.exr", exr);
}

void mesh_seeds(Seeds& seeds, const Scratch& scratch) {
  Mesh mesh;
  for (int i = 0; i < 4; ++i) {
    mesh.vertices.push_back({Vec3f(0.01F * static_cast<float>(i % 2), 0.01F * static_cast<float>(i / 2), 0.1F),
                             Vec3f::UnitZ(),
                             {1, 2, 3},
                             ClassId{2},
                             PanopticId{3}});
  }
  mesh.triangles = {{0, 1, 2}, {1, 3, 2}};
  write_ply(scratch.path() / "mesh.ply", mesh);
  const std::string ply = read_file(scratch.path() / "mesh.ply");
  seeds.put("ply", "mesh", ply);
  const std::string report = R"({"complete": true, "label_set": "small", "labels": [
 {"id": 1, "name": "floor", "is_thing": false, "color": [1, 2, 3]}, {"id": 2, "name": "chair", "is_thing": true, "color": [4, 5, 6]}],
 "dataset": "a", "predictor": "b", "options": {"map": {"voxel_size_m": 0.024}}, "frames": {"used": 2, "skipped": 0, "without_prediction": 1},
 "wall_s": 1.5, "peak_rss_mb": 100, "up": [0, 1, 0], "stages": {"fuse": {"count": 2, "p50_ms": 1, "p95_ms": 2, "mean_ms": 1.5}}})";
  const std::string objects = R"({"objects": [{"id": 3, "class": "chair", "class_id": 2, "probabilities": {"chair": 0.75},
 "first_frame": 0, "last_frame": 1, "observations": 2, "vertices": 4,
 "box": {"min_m": [0, 0, 0.1], "max_m": [0.01, 0.01, 0.1]}, "oriented_box": {"size_m": [0.01, 0.01, 0]}, "surface_area_m2": 0.0001}]})";
  seeds.put("results", "run", {report, objects, "# time x y z qx qy qz qw\n0.5 1 2 3 0 0 0 1\n", ply}, 0);
  seeds.put("results", "semantic", {"1\n2\n3\n4\n"}, 1);
  seeds.put("results", "panoptic", {"1001\n2002\n3000\n0\n"}, 1);
  seeds.put("results", "instances", {"0.txt 5 0.75\n1.txt 7 1\n", "0\n1\n1\n0\n", "1\n0\n0\n0\n"}, 1);
  ScanTruth scan;
  scan.scene = "s";
  for (const MeshVertex& v : mesh.vertices) scan.positions.push_back(v.position);
  scan.colors.assign(4, {9, 8, 7});
  scan.triangles = mesh.triangles;
  scan.class_id = {ClassId{5}, ClassId{5}, ClassId{1}, ClassId::kUnknown};
  scan.instance = {1, 1, 0, 0};
  write_scan_truth(scratch.path(), scan);
  const auto file = [&](const char* suffix) { return read_file(scratch.path() / (std::string("s") + suffix)); };
  seeds.put("ply", "scan", file("_vh_clean_2.ply"));
  const std::string tsv = "id\traw_category\tnyu40id\n1\tchair\t5\n2\twall\t1\n3\todd thing\t\n";
  seeds.put("scan", "scan", {file(".aggregation.json"), file("_vh_clean_2.0.010000.segs.json"), file("_vh_clean_2.ply")});
  seeds.put("scan", "with_categories",
            {file(".aggregation.json"), file("_vh_clean_2.0.010000.segs.json"), file("_vh_clean_2.ply"), tsv});
}

void prediction_seeds(Seeds& seeds, const Scratch& scratch) {
  const Segment chair{ClassId{2}, 0.75F, {{ClassId{2}, 0.5F}}};
  const Segment floor{ClassId{1}, 1, {}, true};
  PredictionWriter(scratch.path() / "p", small_labels(), "a fuzzer").write(0, {some_numbers(8, 6), {chair, floor}});
  const auto file = [&](const char* name) { return read_file(scratch.path() / "p" / name); };
  seeds.put("predictions", "frame", {file("predictions.json"), file("000000.json"), file("000000.png")});
  Image<Rgb> ids(4, 1);
  ids[1] = {7, 0, 0};
  ids[2] = {0, 1, 0};
  const std::string json = R"({"images": [{"id": 1, "file_name": "a_12.jpg"}, {"id": 2, "file_name": "b.jpg"}],
 "annotations": [{"image_id": 1, "file_name": "0.png", "segments_info": [{"id": 7, "category_id": 3, "score": 0.5}, {"id": 256, "category_id": 4}]},
 {"image_id": 2, "file_name": "1.png", "segments_info": []}],
 "categories": [{"id": 3, "name": "chair", "isthing": 1, "color": [1, 2, 3]}, {"id": 4, "name": "wall", "isthing": 0}]})";
  seeds.put("coco", "two_pictures", {json, png(scratch, ids), png(scratch, Image<Rgb>(3, 2))});
}

void video_seeds(Seeds& seeds, const Scratch& scratch) {
  const std::vector<Image<Rgb>> images = {some_colors(16, 16), Image<Rgb>(16, 16), some_colors(16, 16)};
  for (const char* codec : {"libx264rgb", "libx264"}) {
    const fs::path file = scratch.path() / fmt::format("{}.mp4", codec);
    if (test::write_video(file, images, {.codec = codec, .key_every = 2})) seeds.put("video", codec, read_file(file));
  }
}

void toml_seeds(Seeds& seeds) {
  MapOptions map;
  Fields options;
  append_group(options, "map", fields(map));
  seeds.put("toml", "options", {to_toml(options)}, 0);
  seeds.put("toml", "model", {R"(name = "tiny"
task = "instance"
decoder = "yolo_seg"
weights = "tiny.onnx"
weights_folders = ["a", "../b"]
classes = ["wall", "couch"]
[input]
width = 64
height = 32
channels = "bgr"
resize = "letterbox"
mean = [1.0, 1.0, 1.0]
[thresholds]
score = 0.25
[class_map.indoor]
couch = "sofa"
)"},
            1);
  seeds.put("toml", "calibration", {R"([depth]
fx = 500
fy = 500.5
cx = 320
cy = 240
width = 640
height = 480
scale = 1000
invalid = [65535]
distortion = [0.26, -0.95, -0.005, 0.003, 1.16]
[color]
distortion_model = "rational_polynomial"
distortion = [0.1, 0, 0, 0, 0, 0.1, 0, 0.01]
fx = 1000
fy = 1000
cx = 640
cy = 480
width = 1296
height = 968
[color_from_depth]
rotation = [1, 0, 0, 0, 1, 0, 0, 0, 1]
translation = [0.02, 0, 0]
)"},
            2);
  seeds.put("toml", "labels",
            {"name = \"small\"\n[[class]]\nid = 1\nname = \"wall\"\nthing = false\ncolor = [1, 2, 3]\n[[class]]\nid = 2\nname = "
             "\"chair\"\nmax_size_m = 1.5\nsupport = true\n"},
            3);
  Segmentation segmentation{Image<std::uint16_t>(6, 4), {{ClassId{3}, 0.5F, {{ClassId{3}, 0.5F}}}, {ClassId{1}, 1, {}}}};
  for (std::size_t i = 8; i < 20; ++i) segmentation.segment_at[i] = static_cast<std::uint16_t>(1 + i % 2);
  const std::vector<PanopticId> ids = {PanopticId{44}, PanopticId{1}};
  seeds.put("corrections", "labels", {text(encode_labels(segmentation, ids))}, 0);
  seeds.put("corrections", "images", {text(pack_images(small_frame()))}, 3);
  seeds.put("corrections", "updates",
            {R"({"at_frame": 1, "poses": [{"frame": 0, "pose": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]}]})"}, 1);
  seeds.put("corrections", "by_frame", {"0 0 0 0 0 0 0 1\n7 1 2 3 0 0 0 1\n"}, 2);
  seeds.put("corrections", "by_time", {"0.1 1 0 0 0 0 1 0 0 0 0 1 0\n"}, 2);
  seeds.put("toml", "set", {"map.voxel_size_m=0.03"}, 4);
  seeds.put("toml", "set_list", {"networks.models=[\"a\", \"b\"]"}, 4);
}

void map_seeds(Seeds& seeds, const Scratch& scratch) {
  save_small_map(scratch.path() / "a.panoptic");
  seeds.put("map_file", "small", read_file(scratch.path() / "a.panoptic"));
  const PanopticMap small = small_map();
  const VoxelMap& map = small.voxels;
  for (Slot slot = 0; slot < map.block_count(); ++slot) {
    BlockPlanes planes;
    map.block(slot).unpack(planes);
    const Bytes bytes = BlockEncoder().encode(planes);
    seeds.put("block_codec", fmt::format("stored_{}", slot), {text(bytes)}, 0);
    Bytes payload(std::size_t{1} << 17);
    payload.resize(Decompressor().decompress(bytes, payload));
    seeds.put("block_codec", fmt::format("payload_{}", slot), {text(payload)}, 1);
  }
  const auto change = [](int cell, int row, int kind, const std::string& value) {
    return std::string{static_cast<char>(cell), static_cast<char>(row), static_cast<char>(kind),
                       static_cast<char>(value.size())} +
           value;
  };
  seeds.put("map_rows", "nothing", "\0"sv);
  seeds.put("map_rows", "epoch", "\0"s + change(1, 2, 2, "5"));
  seeds.put("map_rows", "options", "\0"s + change(1, 5, 2, "voxel_size_m = 0.02\ntruncation_voxels = 5\n"));
  seeds.put("map_rows", "evidence", "\0"s + change(20, 0, 2, R"({"1":0.5,"2":1.5})"));
  seeds.put("map_rows", "votes", "\0"s + change(22, 0, 2, R"({"log2":3,"bins":[[0,{"2":4}],[1,{"1":2}]]})"));
  seeds.put("map_rows", "views", "\0"s + change(23, 0, 2, "[[1,2,0.75,100,1,2,30,40],[2,2,0.5,100,1,2,30,40]]"));
  seeds.put("map_rows", "parts", "\0"s + change(24, 0, 2, "[[5,3]]") + change(21, 0, 2, "[1,2]"));
  seeds.put("map_rows", "block", "\0"s + change(10, 1, 0, "\5") + change(13, 0, 4, std::string(200, '\1')));
  seeds.put("map_rows", "merged", "\0"s + change(16, 0, 0, "\4") + change(16, 1, 0, "\3"));
  seeds.put("map_rows", "state", "\0"s + change(33, 0, 0, "\12") + change(34, 0, 4, "abcdefghij"));
}

void resume_seeds(Seeds& seeds) {
  const std::string counters = R"({"label_frames": 5, "labelled": 4, "last_frame": 7, "up_sum": [0, -1.5, 0.25]})";
  const std::string together = "\3\0\4\0\2\0\0\0"s;
  const std::string vote = "\1\0\7\0\1\0\0\0\200\77\3\0\0\0\0\100"s;  // one vote in the first block, at voxel 7
  const std::string epochs = "\1\0\0\0\0\0\0\0\2\0\0\0\0\0\0\0"s;
  seeds.put("resume", "state", {counters, together, vote, epochs});
  seeds.put("resume", "empty", {counters, "", "", ""});
}

void http_seeds(Seeds& seeds) {
  const std::string host = "Host: 127.0.0.1:8060\r\n";
  for (const int kind : {0, 2, 3}) {
    seeds.put("http", fmt::format("page_{}", kind), {"GET / HTTP/1.1\r\n" + host + "Accept-Encoding: gzip\r\n\r\n"}, kind);
    seeds.put("http", fmt::format("two_{}", kind),
              {fmt::format("GET /api/state?since=1 HTTP/1.1\r\n{0}\r\nHEAD /api/objects HTTP/1.0\r\n{0}"
                           "Cookie: a=b; panoptic_1=s3cret-token\r\nSec-Fetch-Site: same-origin\r\nConnection: close\r\n\r\n",
                           host)},
              kind);
    seeds.put("http", fmt::format("token_{}", kind), {"GET /api/scene?token=s3cret-token HTTP/1.1\r\n" + host + "\r\n"}, kind);
    seeds.put("http", fmt::format("body_{}", kind),
              {"POST /api/%73tate HTTP/1.1\r\n" + host + "Transfer-Encoding: chunked\r\nContent-Length: 3\r\n\r\nabc"}, kind);
  }
  for (const char* path : {"/api/state?since=0", "/api/chunks?k=0,0,0,1,0,0", "/api/objects", "/api/scene", "/api/frame.jpg",
                           "/api/overlay.png", "/api/scene.glb"}) {
    seeds.put("http", fmt::format("content_{}", fs::path(path).filename().string()), {path}, 1);
  }
}

std::size_t make_seeds(const fs::path& folder) {
  Seeds seeds(folder);
  const Scratch scratch("seeds");
  sens_seeds(seeds, scratch);
  for (const auto& [name, bytes] : small_bags()) seeds.put("bag", name, bytes);
  image_seeds(seeds, scratch);
  depth_seeds(seeds);
  mesh_seeds(seeds, scratch);
  prediction_seeds(seeds, scratch);
  recording_seeds(seeds);
  video_seeds(seeds, scratch);
  toml_seeds(seeds);
  map_seeds(seeds, scratch);
  resume_seeds(seeds);
  http_seeds(seeds);
  return seeds.count();
}

}  // namespace
}  // namespace panoptic::fuzz

int main(int count, char** arguments) {
  if (count != 2) {
    std::fprintf(stderr, "usage: fuzz_make_seeds FOLDER\n");
    return 2;
  }
  try {
    std::printf("%zu seeds\n", panoptic::fuzz::make_seeds(arguments[1]));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "fuzz_make_seeds: %s\n", error.what());
    return 1;
  }
  return 0;
}
