// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/eval/id_space.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panoptic/base/files.h"
#include "panoptic/error.h"
#include "panoptic/eval/benchmark_classes.h"
#include "panoptic/eval/submission.h"
#include "tests/expect_error.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<ClassId> classes(const std::vector<int>& ids) {
  std::vector<ClassId> result;
  for (const int id : ids) result.push_back(static_cast<ClassId>(id));
  return result;
}

TEST(IdSpace, NumbersTheClassesInTheOrderOfTheBenchmark) {
  EXPECT_EQ(class_in(24, IdSpace::kNyu40), ClassId{24});
  EXPECT_EQ(class_in(14, IdSpace::kScannet20), ClassId{16});
  EXPECT_EQ(class_in(20, IdSpace::kScannet20), ClassId{39});
  EXPECT_EQ(class_in(0, IdSpace::kTrain), ClassId{1});
  EXPECT_EQ(class_in(19, IdSpace::kTrain), ClassId{39});
  for (const std::int64_t none : {0, -1, 21, 255}) EXPECT_EQ(class_in(none, IdSpace::kScannet20), ClassId::kUnknown) << none;
  for (const std::int64_t none : {-1, 20, 255}) EXPECT_EQ(class_in(none, IdSpace::kTrain), ClassId::kUnknown) << none;
  EXPECT_THAT(test::error_of([] { id_space_of("coco"); }), HasSubstr("'coco' is no id space"));
}

TEST(IdSpace, AppliesToEveryFormOfAPrediction) {
  const std::filesystem::path folder = test::fresh_folder("pred");
  write_file(folder / "s.txt", "0\n13\n-1\n255\n");
  EXPECT_THAT(read_semantic(folder / "s.txt", IdSpace::kTrain),
              ElementsAre(ClassId{1}, ClassId{16}, ClassId::kUnknown, ClassId::kUnknown));
  write_file(folder / "s.txt", "14002\n-14002\n");
  EXPECT_EQ(read_panoptic(folder / "s.txt", IdSpace::kScannet20), (VertexLabels{classes({16, 0}), {2, 0}}));
  write_file(folder / "s.txt", "m.txt 14 0.5\n");
  write_file(folder / "m.txt", "1\n0\n");
  EXPECT_EQ(read_instances(folder, "s", 2, IdSpace::kScannet20).front().class_id, ClassId{16});
}

TEST(IdSpace, ASpaceThatFitsTheTruthBetterIsNamed) {
  std::vector<int> truth;
  std::vector<int> trained;
  for (const BenchmarkClass& c : benchmark_classes()) {
    truth.insert(truth.end(), 10, number(c.id));
    trained.insert(trained.end(), 10, static_cast<int>(*benchmark_index(c.id)) + 1);
  }
  EXPECT_THAT(label_notices("s", classes(truth), classes(truth)), IsEmpty());
  EXPECT_THAT(
      label_notices("s", classes(truth), classes(trained)),
      ElementsAre(HasSubstr(
          "s: these may be no NYU40 ids: 60.0 % of the vertices agree with the truth, 100.0 % with --id-space scannet20")));
  for (int& id : trained) --id;
  EXPECT_THAT(label_notices("s", classes(truth), classes(trained)), ElementsAre(HasSubstr("--id-space train")));
}

TEST(IdSpace, LabelsOfAnotherFormAreRefused) {
  const std::filesystem::path folder = test::fresh_folder("labels");
  const auto write = [&](const char* name, const char* text) { write_file(folder / name, text); };
  write("semantic.txt", "1\n5\n0\n2\n");
  write("panoptic.txt", "1001\n5002\n0\n2000\n");
  write("shifted.txt", "65536\n327682\n0\n");
  write("blank.txt", "0\n0\n");
  EXPECT_THAT(test::error_of([&] { read_semantic(folder / "panoptic.txt"); }),
              HasSubstr("panoptic.txt: 3 of 3 labels are no class, 1001 for one; class * 1000 + instance is the form of"));
  EXPECT_THAT(test::error_of([&] { read_panoptic(folder / "semantic.txt"); }),
              HasSubstr("semantic.txt: 3 of 3 labels are below 1000, 1 for one; instance and panoptic labels are class * 1000"));
  EXPECT_THAT(test::error_of([&] { read_panoptic(folder / "shifted.txt"); }), HasSubstr("labels are no class, 65 for one"));
  EXPECT_THAT(test::error_of([&] { read_truth(folder, "semantic", SubmissionForm::kInstance); }), HasSubstr("below 1000"));
  EXPECT_THAT(test::error_of([&] { read_truth(folder, "panoptic", SubmissionForm::kSemantic); }), HasSubstr("are no class"));
  EXPECT_THAT(test::error_of([&] { read_truth(folder, "blank", SubmissionForm::kPanoptic); }),
              HasSubstr("of blank names no class"));
  EXPECT_THAT(test::error_of([&] { read_semantic(folder / "panoptic.txt", IdSpace::kTrain); }),
              HasSubstr("is --id-space right?"));
  EXPECT_EQ(read_panoptic(folder / "panoptic.txt").class_id, classes({1, 5, 0, 2}));
  EXPECT_EQ(read_semantic(folder / "semantic.txt"), classes({1, 5, 0, 2}));
}

TEST(IdSpace, ATruthOfInstancesAloneIsRefusedWherePredictionsHaveStuff) {
  EXPECT_THAT(test::error_of([&] {
                require_stuff("s", classes({5, 0, 0}), classes({5, 1, 2}));
              }),
              HasSubstr("s: the ground truth has neither wall nor floor"));
  EXPECT_NO_THROW(require_stuff("s", classes({5, 0, 0}), classes({5, 5, 0})));
  EXPECT_NO_THROW(require_stuff("s", classes({5, 1, 0}), classes({5, 5, 2})));
}

TEST(IdSpace, APredictionWithoutAnyClassIsNamed) {
  EXPECT_THAT(label_notices("s", classes({1, 5}), classes({0, 0})), ElementsAre("s: the prediction names no class"));
}

TEST(IdSpace, ATruthOfAnotherPlaceOrUnitIsNamed) {
  ScanTruth truth;
  truth.scene = "s";
  LabelledMap map;
  for (int i = 0; i < 400; ++i) {
    const Vec3f position(0.05F * static_cast<float>(i % 20), 0.05F * static_cast<float>(i / 20), 0);
    truth.positions.push_back(position);
    map.mesh.vertices.push_back({position, Vec3f::UnitZ(), {}, {}, {}});
  }
  EXPECT_EQ(place_notice(map, truth), "");
  for (std::size_t i = 0; i < 300; ++i) map.mesh.vertices.pop_back();  // a part of the place
  EXPECT_EQ(place_notice(map, truth), "");
  for (MeshVertex& v : map.mesh.vertices) v.position.z() += 2;
  EXPECT_THAT(place_notice(map, truth),
              HasSubstr("only 0 % of the map lies within 10 cm of the ground truth; is the truth of another place"));
  for (Vec3f& p : truth.positions) p *= 1000;
  EXPECT_THAT(place_notice(map, truth), HasSubstr("is the truth in millimetres?"));
}

}  // namespace
}  // namespace panoptic
