// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/sim/furniture_archive.h"

#include <gmock/gmock.h>
#include <zip.h>

#include <map>

#include "panoptic/base/files.h"
#include "panoptic/base/image_io.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

using test::error_of;
using test::fresh_folder;
using testing::AllOf;
using testing::HasSubstr;

using Entries = std::map<std::string, std::string>;

constexpr const char* kList = "PluginFurnitureCatalog.properties";

const std::string kProperties =
    "# comment\nid=Shop#Shop\nid#7=Shop#box\nname#7=Bo\xEEte\nmodel#7=/shop/box/box.obj\nwidth#7=120\ndepth#7=50.5\nheight#7=80\n"
    "elevation#7=10\r\n";

// A floor of two triangles with a texture, a wall to the front without, and an invisible face far away.
const std::string kObj =
    "mtllib box.mtl\nv -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv -1 2 1\nv 1 2 1\nv 900 900 900\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    "usemtl wood\nf 1/1 2/2 3/3 4/4\nusemtl red\nf 4 3 6 5\nusemtl air\nf 1 2 7\n";
const std::string kMtl = "newmtl wood\nKd 0 0 0\nmap_Kd wood.png\nnewmtl red\nKd 1 0 0\nd 0.3\nnewmtl air\nKd 1 1 1\nd 0.0\n";

std::string png(int width, int height) {
  const std::filesystem::path path = fresh_folder("png") / "image.png";
  write_png(path, Image<Rgb>(width, height, {10, 200, 30}));
  return read_file(path);
}

Entries good() {
  return {{kList, kProperties}, {"shop/box/box.obj", kObj}, {"shop/box/box.mtl", kMtl}, {"shop/box/wood.png", png(1024, 256)}};
}

// Stored, not deflated, so that tests find the bytes they damage.
std::filesystem::path write_zip(const Entries& entries, int method = ZIP_CM_STORE) {
  std::filesystem::path path = fresh_folder("zip") / "shop.sh3f";
  int code = 0;
  zip_t* archive = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code);
  for (const auto& [name, bytes] : entries) {
    zip_source_t* source = zip_source_buffer(archive, bytes.data(), bytes.size(), 0);
    const zip_int64_t index = zip_file_add(archive, name.c_str(), source, 0);
    zip_set_file_compression(archive, static_cast<zip_uint64_t>(index), method, 0);
  }
  EXPECT_EQ(zip_close(archive), 0);
  return path;
}

ModelAsset load(const Entries& entries, int method = ZIP_CM_STORE) {
  const FurnitureArchive archive(write_zip(entries, method));
  return archive.load(*archive.find("box"));
}

std::string error_with(const std::string& entry, const std::string& bytes) {
  Entries entries = good();
  entries[entry] = bytes;
  return error_of([&] { load(entries); });
}

std::string error_without(const std::string& entry) {
  Entries entries = good();
  entries.erase(entry);
  return error_of([&] { load(entries); });
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  text.replace(text.find(what), what.size(), by);
  return text;
}

TEST(FurnitureArchive, ListsSizesInMetresAndNamesInUtf8) {
  const FurnitureArchive archive(write_zip(good(), ZIP_CM_DEFLATE));
  ASSERT_EQ(archive.entries().size(), 1U);
  const ArchiveEntry& entry = archive.entries()[0];
  EXPECT_EQ(entry.id, "box");
  EXPECT_EQ(entry.name, "Bo\u00EEte");
  EXPECT_TRUE(entry.size_m.isApprox(Vec3f(1.2F, 0.505F, 0.8F)));
  EXPECT_FLOAT_EQ(entry.elevation_m, 0.1F);
  EXPECT_EQ(archive.find("tub"), nullptr);
}

TEST(FurnitureArchive, TurnsUpToZAndTheFrontToMinusY) {
  const ModelAsset asset = load(good());
  Eigen::AlignedBox3f box;
  for (const Vec3f& p : asset.model.positions) box.extend(p);
  EXPECT_TRUE(box.min().isApprox(Vec3f(-1, -1, 0)));
  EXPECT_TRUE(box.max().isApprox(Vec3f(1, 1, 2)));
  for (const Vec3f& p : asset.model.positions) {
    if (p.z() > 1) {
      EXPECT_FLOAT_EQ(p.y(), -1) << "the wall stands at the front";
    }
  }
}

TEST(FurnitureArchive, AppliesTheRotationOfTheList) {
  Entries entries = good();
  entries[kList] += "modelRotation#7=-1 0 0 0 1 0 0 0 -1\n";
  for (const Vec3f& p : load(entries).model.positions) {
    if (p.z() > 1) {
      EXPECT_FLOAT_EQ(p.y(), 1) << "turned about, the wall stands at the back";
    }
  }
}

TEST(FurnitureArchive, KeepsGlassDropsTheInvisibleAndShrinksTextures) {
  const ModelAsset asset = load(good());
  ASSERT_EQ(asset.model.triangles.size(), 4U);
  ASSERT_EQ(asset.textures.size(), 1U);
  EXPECT_TRUE(asset.textures[0].same_size(512, 128));
  EXPECT_EQ(asset.textures[0](100, 100), (Rgb{10, 200, 30}));
  const Material& floor = asset.materials[asset.model.material_of[0]];
  EXPECT_EQ(floor.texture, 0);
  EXPECT_EQ(floor.color, (Rgb{255, 255, 255}));
  const Material& wall = asset.materials[asset.model.material_of[2]];
  EXPECT_EQ(wall.texture, -1);
  EXPECT_EQ(wall.color, (Rgb{255, 0, 0}));
}

TEST(FurnitureArchive, TextureCoordinatesCountFromTheTop) {
  const ModelAsset asset = load(good());
  for (std::size_t i = 0; i < asset.model.positions.size(); ++i) {
    const Vec3f& p = asset.model.positions[i];
    if (p.isApprox(Vec3f(-1, 1, 0))) {
      EXPECT_TRUE(asset.model.uvs[i].isApprox(Eigen::Vector2f(0, 1)));
    }
  }
}

TEST(FurnitureArchive, UsesTheColourWhereTheTextureLayOnItsAuthorsDisk) {
  Entries entries = good();
  entries["shop/box/box.mtl"] = replaced(kMtl, "wood.png", "C:/My Pictures/wood.png");
  EXPECT_TRUE(load(entries).textures.empty());
}

TEST(FurnitureArchive, NamesWhatIsMissing) {
  EXPECT_THAT(error_of([] { FurnitureArchive(fresh_folder() / "none.sh3f"); }), HasSubstr("none.sh3f"));
  EXPECT_THAT(error_without(kList), HasSubstr(kList));
  for (const char* entry : {"shop/box/box.obj", "shop/box/box.mtl", "shop/box/wood.png"}) {
    EXPECT_THAT(error_without(entry), AllOf(HasSubstr("shop.sh3f"), HasSubstr(entry), HasSubstr("no such entry")));
  }
}

TEST(FurnitureArchive, RefusesATruncatedZipAtEveryLength) {
  const std::string bytes = read_file(write_zip(good()));
  const std::filesystem::path path = fresh_folder("cut") / "cut.sh3f";
  for (std::size_t size = 0; size < bytes.size(); size += bytes.size() / 40 + 1) {
    write_file(path, std::string_view(bytes).substr(0, size));
    EXPECT_THAT(error_of([&] { FurnitureArchive{path}; }), HasSubstr("cut.sh3f")) << size;
  }
}

TEST(FurnitureArchive, RefusesAnEntryWhoseChecksumIsWrong) {
  std::string bytes = read_file(write_zip(good()));
  bytes[bytes.find("usemtl red") + 7] = 'b';
  const std::filesystem::path path = fresh_folder("damaged") / "damaged.sh3f";
  write_file(path, bytes);
  const FurnitureArchive archive(path);
  EXPECT_THAT(error_of([&] { archive.load(*archive.find("box")); }), AllOf(HasSubstr("box.obj"), HasSubstr("damaged")));
}

TEST(FurnitureArchive, RefusesAnEntryThatWouldUnpackToALot) {
  Entries entries = good();
  entries["shop/box/box.obj"] = std::string(50U << 20U, '#');
  EXPECT_THAT(error_of([&] { load(entries, ZIP_CM_DEFLATE); }), AllOf(HasSubstr("box.obj"), HasSubstr("52428800 bytes")));
}

TEST(FurnitureArchive, RefusesHostileGeometry) {
  const char* obj = "shop/box/box.obj";
  EXPECT_THAT(error_with(obj, replaced(kObj, "f 4 3 6 5", "f 4 3 66")), HasSubstr("vertex 66 of 7"));
  EXPECT_THAT(error_with(obj, replaced(kObj, "f 4 3 6 5", "f 4 3 -99")), HasSubstr("box.obj"));
  EXPECT_THAT(error_with(obj, replaced(kObj, "4/4", "4/44")), HasSubstr("texture coordinate 44 of 4"));
  EXPECT_THAT(error_with(obj, replaced(kObj, "v 1 2 1", "v 1 1e30 1")), HasSubstr("vertex 6"));
  EXPECT_THAT(error_with(obj, replaced(kObj, "v 1 2 1", "v 1 1e999 1")), HasSubstr("vertex 6"));
  EXPECT_THAT(error_with(obj, "v 0 0 0\n"), HasSubstr("no faces"));
  EXPECT_THAT(error_with(obj, ""), HasSubstr("no faces"));
  EXPECT_THAT(error_with("shop/box/box.mtl", "newmtl wood\nd 0\nnewmtl red\nd 0\nnewmtl air\nd 0\n"), HasSubstr("invisible"));
  std::string polygon = kObj + "f";
  for (int i = 0; i < 20000; ++i) polygon += " 1";
  EXPECT_THAT(error_with(obj, polygon), HasSubstr("a line of 40001 characters"));
}

TEST(FurnitureArchive, RefusesATextureThatIsNoneOrTooLarge) {
  const char* entry = "shop/box/wood.png";
  EXPECT_THAT(error_with(entry, "GIF89a"), HasSubstr("wood.png"));
  std::string huge = png(8, 8);
  huge[16] = 0x7F;  // the width in the header: two thousand million
  EXPECT_THAT(error_with(entry, huge), AllOf(HasSubstr("wood.png"), HasSubstr("pixels")));
  EXPECT_THAT(error_with(entry, png(64, 64).substr(0, 60)), HasSubstr("wood.png"));
}

TEST(FurnitureArchive, RefusesAListWithoutSenseAndNamesTheEntry) {
  for (const auto& [what, by] : std::map<std::string, std::string>{{"width#7=120", "width#7=0"},
                                                                   {"depth#7=50.5", "depth#7=nan"},
                                                                   {"height#7=80", "height#7=1e9"},
                                                                   {"model#7=", "madel#7="},
                                                                   {"elevation#7=10", "elevation#7=inf"}}) {
    EXPECT_THAT(error_with(kList, replaced(kProperties, what, by)), HasSubstr("Shop#box")) << by;
  }
  EXPECT_THAT(error_with(kList, kProperties + "modelRotation#7=1 0 0\n"), HasSubstr("nine numbers"));
  EXPECT_THAT(error_with(kList, kProperties + "modelRotation#7=0 0 0 0 0 0 0 0 0\n"), HasSubstr("no rotation"));
}

}  // namespace
}  // namespace panoptic
