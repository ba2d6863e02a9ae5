// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The furniture package is a dependency of the program; without it these tests fail rather than pass.
#include "panoptic/sim/catalogue.h"

#include <gmock/gmock.h>

#include <map>
#include <set>

#include "tests/expect_error.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

using test::error_of;
using test::fresh_folder;
using testing::AllOf;
using testing::HasSubstr;

const Catalogue& catalogue() {
  static const Catalogue kCatalogue;
  return kCatalogue;
}

const std::map<std::string, std::string> kClassOfRole = {{"double_bed", "bed"},
                                                         {"single_bed", "bed"},
                                                         {"nightstand", "cabinet"},
                                                         {"wardrobe", "cabinet"},
                                                         {"dresser", "cabinet"},
                                                         {"tv_stand", "cabinet"},
                                                         {"base_cabinet", "cabinet"},
                                                         {"upper_cabinet", "cabinet"},
                                                         {"bathroom_cabinet", "cabinet"},
                                                         {"bookshelf", "bookshelf"},
                                                         {"desk", "desk"},
                                                         {"office_chair", "chair"},
                                                         {"dining_chair", "chair"},
                                                         {"armchair", "chair"},
                                                         {"dining_table", "table"},
                                                         {"coffee_table", "table"},
                                                         {"side_table", "table"},
                                                         {"sofa", "sofa"},
                                                         {"kitchen_counter", "counter"},
                                                         {"kitchen_sink", "sink"},
                                                         {"washbasin", "sink"},
                                                         {"refrigerator", "refrigerator"},
                                                         {"toilet", "toilet"},
                                                         {"bathtub", "bathtub"},
                                                         {"shower_curtain", "shower curtain"},
                                                         {"curtain", "curtain"},
                                                         {"wall_picture", "picture"},
                                                         {"door", "door"},
                                                         {"window", "window"}};

const std::set<std::string> kOtherRoles = {"stove",        "washing_machine", "tv",           "monitor", "desk_item",
                                           "floor_lamp",   "desk_lamp",       "floor_plant",  "bin",     "radiator",
                                           "kitchen_item", "table_item",      "bathroom_item"};

// Rows of a table that no archive is needed for.
std::string row(const std::string& extra) {
  return "[[furniture]]\narchive = \"parametric\"\nrole = \"curtain\"\nclass = \"curtain\"\nid = \"curtain\"\n" + extra;
}

std::string error_of_table(const std::string& table) {
  return error_of([&] { Catalogue(fresh_folder(), table); });
}

TEST(Catalogue, EveryRoleHasItsClassAndAtLeastTwoPieces) {
  const LabelSet labels = load_label_set("scannet20");
  std::map<std::string, int> pieces;
  for (const Furniture& furniture : catalogue().furniture()) {
    const auto known = kClassOfRole.find(furniture.role);
    const std::string expected = known != kClassOfRole.end() ? known->second : "otherfurniture";
    EXPECT_EQ(labels.name_of(furniture.class_id), expected) << furniture.name;
    ++pieces[furniture.role];
  }
  for (const auto& [role, class_name] : kClassOfRole) EXPECT_GE(pieces[role], 2) << role;
  for (const std::string& role : kOtherRoles) EXPECT_GE(pieces[role], 2) << role;
  EXPECT_EQ(pieces.size(), kClassOfRole.size() + kOtherRoles.size());
}

TEST(Catalogue, EveryClassOfScanNetButTheFabricOfTheHouseOccurs) {
  const LabelSet labels = load_label_set("scannet20");
  std::set<ClassId> seen;
  for (const Furniture& furniture : catalogue().furniture()) seen.insert(furniture.class_id);
  for (const LabelClass& label : labels.classes()) {
    EXPECT_EQ(seen.contains(label.id), label.name != "wall" && label.name != "floor") << label.name;
  }
}

TEST(Catalogue, RolesAreFoundInTheOrderOfTheTable) {
  const std::vector<std::size_t> sofas = catalogue().with_role("sofa");
  EXPECT_TRUE(std::is_sorted(sofas.begin(), sofas.end()));
  EXPECT_EQ(static_cast<std::ptrdiff_t>(sofas.size()),
            std::count_if(catalogue().furniture().begin(), catalogue().furniture().end(),
                          [](const Furniture& f) { return f.role == "sofa"; }));
  EXPECT_TRUE(catalogue().with_role("spaceship").empty());
}

// How much of the footprint is covered by level surface within 1.5 cm of the top.
double level_top(const SceneModel& model, const Vec3f& size_m) {
  double area_m2 = 0;
  for (const auto& [a, b, c] : model.triangles) {
    const Vec3f& p = model.positions[a];
    const Vec3f normal = (model.positions[b] - p).cross(model.positions[c] - p);
    const float height_m = (p.z() + model.positions[b].z() + model.positions[c].z()) / 3;
    if (std::abs(normal.z()) > 0.9F * normal.norm() && height_m > size_m.z() - 0.015F) area_m2 += std::abs(normal.z()) / 2.0;
  }
  return area_m2 / static_cast<double>(size_m.x() * size_m.y());
}

// Where along y the upper third's surface lies, on average.
double back_of(const SceneModel& model, const Vec3f& size_m) {
  double moment = 0;
  double area = 0;
  for (const auto& [a, b, c] : model.triangles) {
    const Vec3f center = (model.positions[a] + model.positions[b] + model.positions[c]) / 3;
    if (center.z() < 0.67F * size_m.z()) continue;
    const double weight = (model.positions[b] - model.positions[a]).cross(model.positions[c] - model.positions[a]).norm();
    moment += weight * static_cast<double>(center.y());
    area += weight;
  }
  return moment / area;
}

void expect_sound(const Scene& scene, const Furniture& furniture) {
  const SceneModel& model = scene.models.back();
  ASSERT_EQ(model.uvs.size(), model.positions.size());
  ASSERT_EQ(model.material_of.size(), model.triangles.size());
  EXPECT_LE(model.triangles.size(), 65000U);
  Eigen::AlignedBox3f box;
  for (const Vec3f& p : model.positions) box.extend(p);
  EXPECT_TRUE(box.sizes().isApprox(furniture.size_m, 1e-3F)) << box.sizes().transpose();
  EXPECT_NEAR(box.min().z(), 0, 1e-4F);
  EXPECT_TRUE(box.center().head<2>().isZero(1e-3F));
  for (const auto& triangle : model.triangles) {
    for (const std::uint32_t vertex : triangle) ASSERT_LT(vertex, model.positions.size());
  }
  for (const std::uint32_t material : model.material_of) ASSERT_LT(material, scene.materials.size());
  for (const Material& material : scene.materials) ASSERT_LT(material.texture, static_cast<std::int32_t>(scene.textures.size()));
  for (const Image<Rgb>& texture : scene.textures) ASSERT_LE(std::max(texture.width(), texture.height()), 512);
}

TEST(Catalogue, EveryModelFillsItsSizeAndStandsAsItsRoleNeeds) {
  const std::set<std::string> carriers = {"nightstand",   "dresser",    "tv_stand",        "base_cabinet", "desk",
                                          "dining_table", "side_table", "kitchen_counter", "coffee_table", "washing_machine"};
  const std::set<std::string> seats = {"office_chair", "dining_chair", "armchair", "sofa", "double_bed"};
  for (std::size_t i = 0; i < catalogue().furniture().size(); ++i) {
    const Furniture& furniture = catalogue().furniture()[i];
    SCOPED_TRACE(furniture.role + " " + furniture.name + " " + std::to_string(i));
    Scene scene;
    EXPECT_EQ(catalogue().add_model(i, scene), 0U);
    expect_sound(scene, furniture);
    if (carriers.contains(furniture.role)) {
      EXPECT_GT(level_top(scene.models[0], furniture.size_m), 0.6) << "nothing can stand on it";
    }
    if (seats.contains(furniture.role)) {
      EXPECT_GT(back_of(scene.models[0], furniture.size_m), 0) << "its back is to the front";
    }
    EXPECT_GT(furniture.size_m.maxCoeff(), 0.1F);
    EXPECT_LT(furniture.size_m.z() + furniture.elevation_m, 2.5F);
  }
}

TEST(Catalogue, AModelJoinsASceneBehindWhatIsThere) {
  Scene scene;
  scene.models.resize(3);
  scene.materials.resize(5);
  scene.textures.resize(2);
  const std::size_t desk = catalogue().with_role("desk").at(0);
  EXPECT_EQ(catalogue().add_model(desk, scene), 3U);
  const std::size_t materials = scene.materials.size();
  EXPECT_EQ(catalogue().add_model(desk, scene), 4U);
  EXPECT_EQ(scene.models[3].positions, scene.models[4].positions);
  for (const std::uint32_t material : scene.models[3].material_of) ASSERT_TRUE(material >= 5 && material < materials);
  for (const std::uint32_t material : scene.models[4].material_of) ASSERT_GE(material, materials);
  for (std::size_t i = 5; i < scene.materials.size(); ++i) {
    if (scene.materials[i].texture >= 0) {
      EXPECT_GE(scene.materials[i].texture, 2);
    }
  }
}

TEST(Catalogue, NamesThePackageThatIsMissing) {
  EXPECT_THAT(error_of([] { const Catalogue none(fresh_folder()); }),
              AllOf(HasSubstr("sweethome3d-furniture"), HasSubstr("apt install")));
  EXPECT_THAT(error_of([] { const Catalogue none("/nowhere/at/all"); }), HasSubstr("sweethome3d-furniture"));
}

TEST(Catalogue, RefusesATableWithoutSense) {
  EXPECT_THAT(error_of_table(row("")), HasSubstr("needs size_m"));
  EXPECT_THAT(error_of_table(row("size_m = [1.0, 2.0]\n")), HasSubstr("three numbers"));
  EXPECT_THAT(error_of_table(row("size_m = [1.0, 2.0, -1.0]\n")), HasSubstr("size_m"));
  EXPECT_THAT(error_of_table(row("size_m = [1.0, 1.0, 1.0]\ncolor = [1]\n")), HasSubstr("color"));
  EXPECT_THAT(error_of_table(row("size_m = [1.0, 1.0, 1.0]\nweight = 3\n")), HasSubstr("weight"));
  EXPECT_THAT(error_of_table("[[furniture]]\narchive = \"parametric\"\nrole = \"a\"\nclass = \"rocket\"\nid = \"curtain\"\n"),
              HasSubstr("no class 'rocket'"));
  EXPECT_THAT(error_of_table("[[furniture]]\narchive = \"parametric\"\nrole = \"a\"\nclass = \"bed\"\nid = \"rocket\"\n"),
              HasSubstr("no parametric shape 'rocket'"));
}

TEST(Catalogue, NamesTheEntryThatTheArchiveLacks) {
  EXPECT_THAT(error_of([] {
                Catalogue("/usr/share/sweethome3d/furniture",
                          "[[furniture]]\narchive = \"Scopia\"\nrole = \"a\"\nclass = \"bed\"\nid = \"rocket\"\n");
              }),
              AllOf(HasSubstr("Scopia.sh3f"), HasSubstr("no entry rocket")));
}

TEST(Catalogue, TurnsAModelByQuartersWithItsSize) {
  const std::string table = "[[furniture]]\narchive = \"Scopia\"\nrole = \"sofa\"\nclass = \"sofa\"\nid = \"leather_sofa\"\n";
  const Catalogue straight("/usr/share/sweethome3d/furniture", table);
  const Catalogue turned("/usr/share/sweethome3d/furniture", table + "quarter_turns = 1\n");
  EXPECT_FLOAT_EQ(turned.furniture()[0].size_m.x(), straight.furniture()[0].size_m.y());
  EXPECT_FLOAT_EQ(turned.furniture()[0].size_m.y(), straight.furniture()[0].size_m.x());
  Scene scene;
  straight.add_model(0, scene);
  turned.add_model(0, scene);
  for (std::size_t i = 0; i < scene.models[0].positions.size(); i += 97) {
    const Vec3f& p = scene.models[0].positions[i];
    EXPECT_TRUE(scene.models[1].positions[i].isApprox(Vec3f(-p.y(), p.x(), p.z()), 1e-3F));
  }
}

}  // namespace
}  // namespace panoptic
