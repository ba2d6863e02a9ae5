// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// A hostile header never makes a reader ask for more memory than its file could need. Every file here is small, and claims
// what would take hundreds of megabytes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "panoptic/base/sqlite.h"
#include "panoptic/error.h"
#include "panoptic/io/scan_ply.h"
#include "panoptic/io/sens.h"
#include "panoptic/io/sens_writer.h"
#include "panoptic/map_file.h"
#include "panoptic/mapfile/block_codec.h"
#include "panoptic/mapfile/map_rows.h"
#include "panoptic/mapfile/map_writer.h"
#include "panoptic/outputs.h"
#include "panoptic/predict/coco_panoptic.h"
#include "panoptic/predict/prediction_io.h"
#include "panoptic/source.h"
#include "tests/fresh_folder.h"
#include "tests/limits/allocation_meter.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;
using test::allocations_of;
using test::fresh_folder;

// Memory that reading any file takes, however small: buffers, messages, codecs' tables.
constexpr std::size_t kAlways = 4U << 20;

// Whether the reader refuses the file is for other tests.
template <typename Read>
void expect_at_most(std::size_t bytes, const Read& read) {
  const test::Allocations taken = allocations_of([&] {
    try {
      read();
    } catch (const Error&) {
    }
  });
  EXPECT_LE(taken.largest, bytes);
  EXPECT_LE(taken.peak, bytes);
}

std::string written(const fs::path& path) { return read_file(path); }

template <typename T>
void overwrite(std::string& bytes, std::size_t at, T value) {
  ASSERT_LE(at + sizeof value, bytes.size());
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

TEST(AllocationMeter, CountsWhatIsTakenAndNotWhatIsGivenBack) {
  const test::Allocations taken = allocations_of([] {
    for (int i = 0; i < 10; ++i) std::vector<char>(1000000).at(5) = 1;
    std::vector<char> kept(2000000, 1);
    std::vector<char> beside(500000, 1);
    kept[0] = beside[0];
  });
  EXPECT_GE(taken.largest, 2000000U);
  EXPECT_LT(taken.largest, 2100000U);
  EXPECT_GE(taken.peak, 2500000U);
  EXPECT_LT(taken.peak, 2700000U);
}

// Where the fields of a .sens header lie that has a sensor's name of so many bytes.
struct SensPlaces {
  std::size_t compression;
  std::size_t sizes;
  std::size_t frames;
  std::size_t first_frame;
};
SensPlaces places_of(const std::string& sens) {
  std::uint64_t name = 0;
  std::memcpy(&name, sens.data() + 4, sizeof name);
  const std::size_t compression = 4 + 8 + name + 4 * 64;
  return {compression, compression + 8, compression + 28, compression + 36};
}

class SensLimits : public testing::Test {
 protected:
  SensLimits() {
    Frame frame;
    frame.depth_camera = frame.color_camera = {16, 12, 14, 14, 7.5, 5.5};
    frame.depth = Image<float>(16, 12, 1.5F);
    frame.color = Image<Rgb>(16, 12, Rgb{1, 2, 3});
    SensWriter writer(path_, frame.depth_camera);
    writer.write(encode_sens_frame(frame, 50));
    writer.finish();
    bytes_ = written(path_);
    at_ = places_of(bytes_);
  }
  void read() const {
    const SensDataset dataset(path_);
    for (std::size_t i = 0; i < dataset.size(); ++i) dataset.read(i);
  }
  void claim_size(std::uint32_t width, std::uint32_t height) {
    for (const std::size_t image : {0U, 8U}) {
      overwrite(bytes_, at_.sizes + image, width);
      overwrite(bytes_, at_.sizes + image + 4, height);
    }
  }

  fs::path path_ = fresh_folder() / "a.sens";
  std::string bytes_;
  SensPlaces at_{};
};

TEST_F(SensLimits, ASoundFileIsRead) {
  EXPECT_TRUE(SensDataset(path_).read(0).frame.has_value());
  expect_at_most(kAlways, [&] { read(); });
}

TEST_F(SensLimits, ClaimedImageSizesTakeNothing) {
  claim_size(6400, 4800);
  for (const int color : {0, 1, 2}) {
    for (const int depth : {0, 1}) {
      overwrite(bytes_, at_.compression, color);
      overwrite(bytes_, at_.compression + 4, depth);
      write_file(path_, bytes_);
      expect_at_most(kAlways, [&] { read(); });
    }
  }
}

TEST_F(SensLimits, ClaimedFrameCountsTakeNothing) {
  for (const std::uint64_t frames : {std::uint64_t{1} << 24, std::uint64_t{1} << 60, ~std::uint64_t{0}}) {
    overwrite(bytes_, at_.frames, frames);
    write_file(path_, bytes_);
    expect_at_most(kAlways, [&] { read(); });
  }
}

TEST_F(SensLimits, ClaimedBlobsTakeNothing) {
  for (const std::size_t field : {80U, 88U}) {  // bytes of the colour, then of the depth
    for (const std::uint64_t claimed : {std::uint64_t{60} << 20, ~std::uint64_t{0}}) {
      std::string bytes = bytes_;
      overwrite(bytes, at_.first_frame + field, claimed);
      write_file(path_, bytes);
      expect_at_most(kAlways, [&] { read(); });
    }
  }
}

// The same picture with other sides in its header.
std::vector<std::uint8_t> png_claiming(std::uint8_t megapixel_sides) {
  std::vector<std::uint8_t> png = encode_png(Image<std::uint16_t>(8, 8));
  png[18] = png[22] = megapixel_sides;  // 256 pixels each
  return png;
}

TEST(ImageLimits, ClaimedSidesTakeNothing) {
  const std::vector<std::uint8_t> png = png_claiming(0x1F);  // 7,944 x 7,944
  expect_at_most(kAlways, [&] { decode_gray16(png, "a.png"); });
  expect_at_most(kAlways, [&] { decode_rgb(png, "a.png"); });
  std::vector<std::uint8_t> jpeg = encode_jpeg(Image<Rgb>(16, 16), 50);
  const std::uint8_t frame_header[] = {0xFF, 0xC0, 0x00, 0x11, 8};
  const auto at = std::search(jpeg.begin(), jpeg.end(), std::begin(frame_header), std::end(frame_header));
  ASSERT_NE(at, jpeg.end());
  at[5] = at[7] = 0x1F;
  expect_at_most(kAlways, [&] { decode_rgb(jpeg, "a.jpg"); });
  for (const std::string text : {"P5 7944 7944 255 ab", "P6 7944 7944 65535 ab", "P3 7944 7944 255 1 2 3", "P2 7944 7944 9 1"}) {
    const std::vector<std::uint8_t> pnm(text.begin(), text.end());
    expect_at_most(kAlways, [&] { decode_rgb(pnm, "a.pnm"); });
  }
  const std::string tiff("II*\0\10\0\0\0\2\0\0\1\4\0\1\0\0\0\0\37\0\0\1\1\4\0\1\0\0\0\0\37\0\0\0\0\0\0", 38);
  const std::vector<std::uint8_t> bytes(tiff.begin(), tiff.end());
  expect_at_most(kAlways, [&] { decode_rgb(bytes, "a.tiff"); });
}

TEST(PlyLimits, ClaimedCountsTakeNothing) {
  const fs::path folder = fresh_folder();
  Mesh mesh;
  mesh.vertices.resize(3);
  mesh.triangles = {{0, 1, 2}};
  write_ply(folder / "mesh.ply", mesh);
  ScanTruth scan;
  scan.positions.resize(3);
  scan.triangles = mesh.triangles;
  write_scan_ply(folder / "scan.ply", scan);
  for (const char* name : {"mesh.ply", "scan.ply"}) {
    const std::string sound = written(folder / name);
    for (const char* element : {"element vertex 3", "element face 1"}) {
      for (const char* count : {"30000000", "2147483647", "4294967295", "18446744073709551615"}) {
        std::string bytes = sound;
        const std::size_t at = bytes.find(element);
        ASSERT_NE(at, std::string::npos);
        bytes.replace(at + std::strlen(element) - 1, 1, count);
        write_file(folder / "claims.ply", bytes);
        expect_at_most(kAlways, [&] { read_ply(folder / "claims.ply"); });
        expect_at_most(kAlways, [&] {
          ScanTruth read;
          read_scan_ply(folder / "claims.ply", read);
        });
      }
    }
  }
}

TEST(PlyLimits, ClaimedListsTakeNothing) {
  const fs::path file = fresh_folder() / "list.ply";
  write_file(file,
             "ply\nformat binary_little_endian 1.0\nelement odd 1\nproperty list uint double numbers\nelement vertex 1\n"
             "property float x\nproperty float y\nproperty float z\nelement face 1\n"
             "property list uint int vertex_indices\nend_header\n" +
                 std::string(40, '\xF0'));
  expect_at_most(kAlways, [&] {
    ScanTruth read;
    read_scan_ply(file, read);
  });
}

TEST(PredictionLimits, ClaimedSizesTakeNothing) {
  const fs::path folder = fresh_folder();
  const LabelSet labels("one", {{ClassId{1}, "wall", false, {}}});
  PredictionWriter(folder / "p", labels, "test").write(0, {Image<std::uint16_t>(8, 8, 1), {{ClassId{1}, 1, {}}}});
  std::string json = written(folder / "p" / "predictions.json");
  for (const char* side : {"\"width\": 8", "\"height\": 8"}) {
    ASSERT_NE(json.find(side), std::string::npos);
    json.replace(json.find(side) + std::strlen(side) - 1, 1, "7944");
  }
  write_file(folder / "p" / "predictions.json", json);
  std::vector<std::uint8_t> png = png_claiming(0x1F);
  png[19] = png[23] = 8;
  write_file(folder / "p" / "000000.png", png);
  expect_at_most(kAlways, [&] { read_prediction(open_predictions(folder / "p"), 0); });

  CocoPanoptic coco{.labels = labels};
  coco.pictures[0] = {folder / "p" / "000000.png", {}};
  expect_at_most(kAlways, [&] { read_coco_frame(coco, 0); });
}

TEST(RecordingLimits, SizesInCalibrationsTakeNothing) {
  const fs::path folder = fresh_folder();
  fs::create_directories(folder / "results");
  write_png(folder / "results" / "frame000000.png", Image<Rgb>(8, 6));
  write_png(folder / "results" / "depth000000.png", Image<std::uint16_t>(8, 6, 1000));
  write_file(folder / "traj.txt", "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n");
  for (const char* side : {"65536", "9007199254740993", "1e300", "-1"}) {
    write_file(folder / "cam_params.json",
               fmt::format(R"({{"camera": {{"w": {0}, "h": {0}, "fx": 7, "fy": 7, "cx": 3, "cy": 2, "scale": 1000}}}})", side));
    expect_at_most(kAlways, [&] { open_recording(folder)->read(0); });
  }
}

class MapLimits : public testing::Test {
 protected:
  MapLimits() {
    const LabelSet labels("one", {{ClassId{1}, "wall", false, {}}, {ClassId{2}, "chair", true, {}}});
    PanopticMap map({}, labels);
    map.voxels.block(map.voxels.allocate({0, 0, 0})).set(0, {.weight = 1, .label_weight = 1, .vote_sum = 1});
    MapUpdate update = whole_map(map);
    update.notes.states["bytes"] = Bytes(100, 7);
    save_map(path_, {MapOptions{}, labels}, update);
  }
  void change(const std::string& sql) const { Database(path_, DatabaseAccess::kWrite).execute(sql.c_str()); }

  // SQLite's page cache holds up to 2 MB.
  static constexpr std::size_t kMost = kAlways + (2U << 20);
  fs::path path_ = fresh_folder() / "a.panoptic";
};

TEST_F(MapLimits, ASoundFileIsRead) {
  expect_at_most(kMost, [&] { EXPECT_EQ(load_map(path_).map.voxels.block_count(), 1U); });
}

TEST_F(MapLimits, AStateThatClaimsToBeLargeTakesNothing) {
  const Bytes packed = Compressor().compress(Bytes(100, 7));
  Database database(path_, DatabaseAccess::kWrite);
  Statement change(database, "UPDATE state SET size = ?, checksum = ?, bytes = ?");
  for (const std::int64_t size : {std::int64_t{1} << 26, std::int64_t{1} << 30}) {
    change.bind(size).bind(row_checksum({size}, packed)).bind(std::span<const std::uint8_t>(packed)).run();
    expect_at_most(kMost, [&] { load_map(path_); });
  }
}

TEST_F(MapLimits, ABlockThatUnpacksWithoutEndTakesABlock) {
  const Bytes packed = Compressor().compress(Bytes(std::size_t{64} << 20));  // a few kB
  ASSERT_LT(packed.size(), 16384U);
  auto block = std::make_unique<BlockPlanes>();
  expect_at_most(kMost, [&] { EXPECT_NE(BlockDecoder().decode(packed, *block), nullptr); });
}

TEST_F(MapLimits, CountsInTheMetaTableTakeNothing) {
  change("UPDATE meta SET value = '4611686018427387904' WHERE key = 'ids_given'");
  expect_at_most(kMost, [&] { load_map(path_); });
}

// A count can claim at most as many objects as there can be at all.
TEST_F(MapLimits, ObjectsThatAreNotThereTakeLittle) {
  change("UPDATE meta SET value = '60000' WHERE key = 'ids_given'");
  expect_at_most(kMost + 3 * sizeof(Object) * 60000, [&] { load_map(path_); });
}

}  // namespace
}  // namespace panoptic
