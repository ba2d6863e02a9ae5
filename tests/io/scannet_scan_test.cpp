// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/scannet_scan.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <random>
#include <set>
#include <string>

#include "panoptic/base/files.h"
#include "panoptic/base/json.h"
#include "panoptic/io/category_map.h"
#include "panoptic/io/scan_ply.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;
using test::error_of;
using test::fresh_folder;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr ClassId kWall{1};
constexpr ClassId kChair{5};
constexpr ClassId kOther{39};

// Two walls' worth of stuff, two chairs, one thing of another class, one vertex without annotation.
ScanTruth small_scan() {
  ScanTruth truth;
  truth.scene = "scene0001_00";
  for (int i = 0; i < 6; ++i) {
    const auto f = static_cast<float>(i);
    truth.positions.emplace_back(f, 0.5F * f, -f);
    truth.colors.push_back({static_cast<std::uint8_t>(i), 7, 255});
  }
  truth.triangles = {{0, 1, 2}, {5, 4, 3}};
  truth.class_id = {kWall, kChair, kChair, kOther, ClassId::kUnknown, kWall};
  truth.instance = {0, 7, 2, 3, 0, 0};
  truth.names = {{2, "chair"}, {7, "Chair"}, {3, "piano"}};
  return truth;
}

// A PLY file from header lines and raw bytes.
fs::path write_mesh(const std::string& header, const std::string& data) {
  fs::path path = fresh_folder("ply") / "mesh.ply";
  std::ofstream(path, std::ios::binary) << "ply\nformat binary_little_endian 1.0\n" << header << "end_header\n" << data;
  return path;
}

template <typename T>
std::string raw(T value) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  return bytes;
}

std::string point(float x) { return raw(x) + raw(x + 1) + raw(x + 2); }

constexpr const char* kPoint = "property float x\nproperty float y\nproperty float z\n";
constexpr const char* kCorners = "property list uchar int vertex_indices\n";

std::string why_mesh_refused(const std::string& header, const std::string& data) {
  const fs::path path = write_mesh(header, data);
  ScanTruth scan;
  return error_of([&] { read_scan_ply(path, scan); });
}

fs::path scan_folder() {
  fs::path folder = fresh_folder("scene0001_00");
  write_scan_truth(folder, small_scan());
  return folder;
}

const char* const kAggregation = "scene0001_00.aggregation.json";
const char* const kSegments = "scene0001_00_vh_clean_2.0.010000.segs.json";

std::string why_scan_refused(const char* file, const std::string& text) {
  const fs::path folder = scan_folder();
  write_file(folder / file, text);
  return error_of([&] { read_scan_truth(folder); });
}

TEST(ScannetScan, ComesBackAsItWasWritten) {
  const ScanTruth wrote = small_scan();
  std::vector<std::string> warnings;
  const ScanTruth read = read_scan_truth(scan_folder(), {}, &warnings);
  EXPECT_EQ(read.scene, wrote.scene);
  EXPECT_EQ(read.positions, wrote.positions);
  EXPECT_EQ(read.colors, wrote.colors);
  EXPECT_EQ(read.triangles, wrote.triangles);
  EXPECT_EQ(read.class_id, wrote.class_id);
  EXPECT_THAT(read.instance, ElementsAre(8, 7, 2, 3, 0, 8)) << "stuff without an instance is one above all others";
  EXPECT_EQ(read.names.at(7), "Chair");
  EXPECT_EQ(read.names.at(3), "furniture") << "a piano is no NYU40 class, so its class is written";
  EXPECT_THAT(warnings, ElementsAre());
}

TEST(ScannetScan, IsWrittenTheSameEveryTime) {
  const fs::path folder = scan_folder();
  const fs::path again = fresh_folder("again");
  write_scan_truth(again, read_scan_truth(folder));
  for (const char* name : {kAggregation, kSegments, "scene0001_00_vh_clean_2.ply"}) {
    EXPECT_EQ(read_file(folder / name), read_file(again / name)) << name;
  }
}

TEST(ScannetScan, GivesTheLaterGroupASegmentThatTwoClaim) {
  const fs::path folder = scan_folder();
  write_file(folder / kSegments, R"({"segIndices": [900, 900, 41, 41, 5, 123456789012]})");
  write_file(folder / kAggregation, R"({"segGroups": [
      {"id": 0, "objectId": 0, "segments": [900, 41, 77], "label": "chair"},
      {"id": 1, "objectId": 1, "segments": [41], "label": "table"},
      {"id": 2, "objectId": 9, "segments": [123456789012], "label": "spaceship"}]})");
  std::vector<std::string> warnings;
  const ScanTruth read = read_scan_truth(folder, {}, &warnings);
  EXPECT_THAT(read.class_id, ElementsAre(kChair, kChair, ClassId{7}, ClassId{7}, ClassId{0}, ClassId{0}));
  EXPECT_THAT(read.instance, ElementsAre(1, 1, 2, 2, 0, 10));
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("'spaceship'"), HasSubstr("1 segments are claimed by two groups")));
}

TEST(ScannetScan, TakesTheCategoryMapGivenOrFoundAboveTheScan) {
  const fs::path root = fresh_folder("root");
  const fs::path folder = root / "scans" / "scene0001_00";
  write_scan_truth(folder, small_scan());
  const std::string head = "id\traw_category\tcategory\tnyu40id\r\n";
  write_file(root / "scannetv2-labels.combined.tsv", head + "1\twall\twall\t2\r\n2\tchair\tchair\t6\r\n3\tChair\tchair\t\r\n");
  std::vector<std::string> warnings;
  EXPECT_THAT(read_scan_truth(folder, {}, &warnings).class_id,
              ElementsAre(ClassId{2}, ClassId{0}, ClassId{6}, ClassId{0}, ClassId{0}, ClassId{2}));
  EXPECT_THAT(warnings, ElementsAre(HasSubstr("1 labels are no known category and count as not annotated: 'furniture'")));
  write_file(root / "other.tsv", "nyu40id\traw_category\n9\twall\n");
  EXPECT_EQ(read_scan_truth(folder, root / "other.tsv").class_id[0], ClassId{9});
}

TEST(ScannetScan, RefusesACategoryMapThatIsNone) {
  const fs::path folder = scan_folder();
  const auto why = [&](const std::string& text) {
    write_file(folder / "map.tsv", text);
    return error_of([&] { read_scan_truth(folder, folder / "map.tsv"); });
  };
  EXPECT_THAT(why(""), HasSubstr("map.tsv: empty"));
  EXPECT_THAT(why("raw_category,nyu40id\n"), HasSubstr("map.tsv:1: no column 'raw_category'"));
  EXPECT_THAT(why("raw_category\tnyu40id\nchair\t5\ntable\n"), HasSubstr("map.tsv:3: 1 of 2 columns"));
  EXPECT_THAT(why("raw_category\tnyu40id\nchair\t41\n"), HasSubstr("map.tsv:2: '41' is no NYU40 class"));
  EXPECT_THAT(why("raw_category\tnyu40id\nchair\t-5\n"), HasSubstr("map.tsv:2: '-5' is no NYU40 class"));
  EXPECT_THAT(why("raw_category\tnyu40id\nchair\tfive\n"), HasSubstr("'five' is no NYU40 class"));
}

TEST(ScannetScan, RefusesFilesThatContradictEachOther) {
  EXPECT_THAT(why_scan_refused(kSegments, R"({"segIndices": [1, 2, 3]})"),
              AllOf(HasSubstr("segs.json: segIndices of 3 vertices"), HasSubstr("mesh beside it has 6")));
  EXPECT_THAT(why_scan_refused(kSegments, R"({"segIndices": [1, 2, 3, 4, 5, -6]})"), HasSubstr("expected a whole number"));
  EXPECT_THAT(why_scan_refused(kSegments, R"({"segIndices": [1, 2, 3, 4, 5, 0.5]})"), HasSubstr("expected a whole number"));
  EXPECT_THAT(why_scan_refused(kSegments, R"({"segIndices": 6})"), HasSubstr("segIndices: not a list"));
  EXPECT_THAT(why_scan_refused(kSegments, "[]"), HasSubstr("no 'segIndices'"));
  EXPECT_THAT(why_scan_refused(kSegments, R"({"segIndices": [)"), HasSubstr("not valid JSON"));
  EXPECT_THAT(why_scan_refused(kSegments, std::string(100000, '[')), HasSubstr("not valid JSON"));
  EXPECT_THAT(why_scan_refused(kAggregation, "{}"), HasSubstr("no 'segGroups'"));
  EXPECT_THAT(why_scan_refused(kAggregation, R"({"segGroups": [3]})"), HasSubstr("segGroups[0]: no 'objectId'"));
  EXPECT_THAT(why_scan_refused(kAggregation, R"({"segGroups": [{"objectId": 65535, "label": "a", "segments": []}]})"),
              HasSubstr("segGroups[0].objectId: expected a whole number from 0 to 65534"));
  EXPECT_THAT(why_scan_refused(kAggregation, R"({"segGroups": [{"objectId": 1, "label": 5, "segments": []}]})"),
              HasSubstr("segGroups[0].label: not a text"));
  EXPECT_THAT(why_scan_refused(kAggregation, R"({"segGroups": [{"objectId": 1, "label": "a", "segments": ["b"]}]})"),
              HasSubstr("segGroups[0].segments: expected a whole number"));
}

TEST(ScannetScan, RefusesAFolderWithoutAScanOrWithSeveral) {
  const fs::path folder = fresh_folder("folder");
  EXPECT_THAT(error_of([&] { read_scan_truth(folder); }), HasSubstr("no scan here"));
  EXPECT_THAT(error_of([&] { read_scan_truth(folder / "none"); }), HasSubstr("cannot read the folder"));
  ScanTruth scan = small_scan();
  write_scan_truth(folder, scan);
  EXPECT_EQ(read_scan_truth(folder).scene, "scene0001_00");
  scan.scene = "scene0001_01";
  write_scan_truth(folder, scan);
  EXPECT_THAT(error_of([&] { read_scan_truth(folder); }), HasSubstr("2 scans in one folder"));
  fs::remove(folder / "scene0001_01.aggregation.json");
  fs::remove(folder / "scene0001_00_vh_clean_2.ply");
  EXPECT_THAT(error_of([&] { read_scan_truth(folder); }), HasSubstr("scene0001_01.aggregation.json"));
}

TEST(ScannetScan, RefusesToWriteWhatTheFilesCannotSay) {
  const auto why = [](const ScanTruth& truth) { return error_of([&] { write_scan_truth(fresh_folder("out"), truth); }); };
  ScanTruth truth = small_scan();
  truth.instance[3] = 2;
  EXPECT_THAT(why(truth), HasSubstr("instance 2 is chair and otherfurniture"));
  truth = small_scan();
  truth.instance.pop_back();
  EXPECT_THAT(why(truth), HasSubstr("6 classes and 5 instances"));
  truth = small_scan();
  truth.class_id[0] = ClassId{41};
  EXPECT_THAT(why(truth), HasSubstr("vertex 0 is of class 41"));
  truth = small_scan();
  truth.instance[1] = 65535;
  EXPECT_THAT(why(truth), HasSubstr("too many instances"));
  truth = small_scan();
  truth.scene = "../scene";
  EXPECT_THAT(why(truth), HasSubstr("no name for a scan"));
}

TEST(ScanPly, TakesOtherPropertiesElementsAndTypes) {
  const std::string header =
      std::string("comment made by hand\nelement camera 1\nproperty list uchar float view\nelement vertex 3\n") +
      "property double x\nproperty ushort label\nproperty float y\nproperty short z\nproperty uchar blue\n" +
      "property uchar red\nproperty uchar green\nproperty uchar alpha\nelement face 1\nproperty uchar flags\n" +
      "property list int ushort vertex_index\nproperty list uchar float uv\n";
  std::string data = raw<std::uint8_t>(2) + raw(1.0F) + raw(2.0F);
  for (std::int16_t i = 0; i < 3; ++i) {
    data += raw(i + 0.5) + raw<std::uint16_t>(9) + raw(2.0F) + raw<std::int16_t>(static_cast<std::int16_t>(-i));
    for (const int channel : {30, 10, 20, 255}) data += raw(static_cast<std::uint8_t>(channel));
  }
  data += raw<std::uint8_t>(1) + raw<std::int32_t>(3);
  for (const int corner : {2, 0, 1}) data += raw(static_cast<std::uint16_t>(corner));
  data += raw<std::uint8_t>(1) + raw(0.5F);
  ScanTruth scan;
  read_scan_ply(write_mesh(header, data), scan);
  EXPECT_THAT(scan.positions, ElementsAre(Vec3f(0.5F, 2, 0), Vec3f(1.5F, 2, -1), Vec3f(2.5F, 2, -2)));
  EXPECT_THAT(scan.colors, ElementsAre(Rgb{10, 20, 30}, Rgb{10, 20, 30}, Rgb{10, 20, 30}));
  EXPECT_THAT(scan.triangles, ElementsAre(std::array<std::uint32_t, 3>{2, 0, 1}));
}

TEST(ScanPly, TakesAMeshWithoutColoursAndFaces) {
  ScanTruth scan = small_scan();
  read_scan_ply(write_mesh(std::string("element vertex 1\r\n") + kPoint, point(1)), scan);
  EXPECT_THAT(scan.positions, ElementsAre(Vec3f(1, 2, 3)));
  EXPECT_THAT(scan.colors, ElementsAre(Rgb{}));
  EXPECT_TRUE(scan.triangles.empty());
}

TEST(ScanPly, RefusesHostileHeaders) {
  const std::string vertex = std::string("element vertex 1\n") + kPoint;
  EXPECT_THAT(why_mesh_refused("element vertex 999999999\n" + std::string(kPoint), point(1)), HasSubstr("the file is cut off"));
  EXPECT_THAT(why_mesh_refused("element vertex 99999999999999999999\n" + std::string(kPoint), ""),
              HasSubstr("line 3 has no usable count"));
  EXPECT_THAT(why_mesh_refused("element vertex -1\n" + std::string(kPoint), ""), HasSubstr("no usable count: '-1'"));
  EXPECT_THAT(why_mesh_refused("element vertex 2000000000\n", ""), HasSubstr("records without properties"));
  EXPECT_THAT(why_mesh_refused("property float x\n", ""), HasSubstr("a property before any element"));
  EXPECT_THAT(why_mesh_refused("element vertex 1\nproperty quad x\n", ""), HasSubstr("unknown type 'quad'"));
  EXPECT_THAT(why_mesh_refused("element vertex 1\nproperty list float int x\n", ""), HasSubstr("counts a list"));
  EXPECT_THAT(why_mesh_refused("element vertex 1\nproperty float x\nproperty float y\n", point(1)), HasSubstr("no 'z'"));
  EXPECT_THAT(why_mesh_refused("element vertex 1\nproperty list uchar int x\n", point(1)), HasSubstr("vertices hold lists"));
  EXPECT_THAT(why_mesh_refused("banana\n", ""), HasSubstr("line 3 is neither element nor property"));
  EXPECT_THAT(why_mesh_refused("", ""), HasSubstr("no vertices"));
  EXPECT_THAT(why_mesh_refused(std::string(100000, 'c'), ""), HasSubstr("without end_header"));
  EXPECT_THAT(why_mesh_refused(vertex, point(1) + "x"), HasSubstr("1 bytes follow what the PLY header announces"));
}

TEST(ScanPly, RefusesHostileData) {
  const std::string header = std::string("element vertex 1\n") + kPoint + "element face 1\n" + kCorners;
  const std::string corners = raw<std::int32_t>(0) + raw<std::int32_t>(0);
  EXPECT_THAT(why_mesh_refused(header, point(1) + raw<std::uint8_t>(3) + corners + raw<std::int32_t>(1)),
              HasSubstr("face 0 names vertex 1 of 1"));
  EXPECT_THAT(why_mesh_refused(header, point(1) + raw<std::uint8_t>(3) + corners + raw<std::int32_t>(-1)),
              HasSubstr("names vertex -1"));
  EXPECT_THAT(why_mesh_refused(header, point(1) + raw<std::uint8_t>(4) + corners + corners), HasSubstr("face 0 has 4 corners"));
  EXPECT_THAT(why_mesh_refused(header, point(1) + raw<std::uint8_t>(3) + corners), HasSubstr("cut off at byte"));
  EXPECT_THAT(why_mesh_refused(std::string("element vertex 1\n") + kPoint, point(NAN)), HasSubstr("vertex 0 is not finite"));
  const std::string edges = std::string("element vertex 1\n") + kPoint + "element edge 1\nproperty list int double e\n";
  EXPECT_THAT(why_mesh_refused(edges, point(1) + raw<std::int32_t>(-5)), HasSubstr("a list of -5 numbers"));
  EXPECT_THAT(why_mesh_refused(edges, point(1) + raw<std::int32_t>(2000000000)), HasSubstr("cut off at byte"));
  EXPECT_THAT(
      why_mesh_refused(std::string("element vertex 1\n") + kPoint + "element face 1\nproperty int a\n", point(1) + raw(1)),
      HasSubstr("no vertex_indices"));
}

TEST(ScanPly, RefusesTextPly) {
  const fs::path path = fresh_folder() / "mesh.ply";
  write_file(path, "ply\nformat ascii 1.0\nelement vertex 0\nend_header\n");
  ScanTruth scan;
  EXPECT_THAT(error_of([&] { read_scan_ply(path, scan); }), HasSubstr("save the mesh as binary little-endian PLY"));
}

// Every damage is either harmless or one line.
TEST(ScanPly, SurvivesDamagedBytes) {
  const fs::path folder = scan_folder();
  const std::string good = read_file(folder / "scene0001_00_vh_clean_2.ply");
  std::mt19937_64 random(5);
  std::set<std::string> complaints;
  for (int round = 0; round < 400; ++round) {
    std::string bytes = good;
    for (std::uint64_t i = 0; i <= random() % 3; ++i) bytes[random() % bytes.size()] = static_cast<char>(random());
    if (round % 4 == 0) bytes.resize(random() % bytes.size());
    std::ofstream(folder / "bad.ply", std::ios::binary) << bytes;
    ScanTruth scan;
    try {
      read_scan_ply(folder / "bad.ply", scan);
      EXPECT_EQ(scan.colors.size(), scan.positions.size());
    } catch (const Error& error) {
      complaints.insert(std::string(error.what()).substr((folder / "bad.ply").string().size()));
    }
  }
  EXPECT_GT(complaints.size(), 20U);
}

TEST(Nyu40, KnowsItsNamesInEverySpelling) {
  for (std::uint16_t n = 1; n <= kNyu40Classes; ++n) EXPECT_EQ(number(nyu40_class(nyu40_name(ClassId{n}))), n);
  EXPECT_EQ(nyu40_class("Night Stand"), ClassId{32});
  EXPECT_EQ(nyu40_class("other_furniture"), kOther);
  EXPECT_EQ(nyu40_class("refridgerator"), ClassId{24});
  EXPECT_EQ(nyu40_class(""), ClassId::kUnknown);
  EXPECT_EQ(nyu40_name(ClassId{41}), "unknown");
}

}  // namespace
}  // namespace panoptic
