// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/image_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panoptic/error.h"
#include "tests/fresh_folder.h"
#include "tests/io/recordings.h"

namespace panoptic::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

FileRecording recording_of(const RecordingFiles& files) {
  FileRecording recording{"test", "/recording", {}, {}};
  add_frames_by_name(recording, files);
  return recording;
}

// "colour+depth" of each frame.
std::vector<std::string> pairs(const FileRecording& recording) {
  std::vector<std::string> result;
  for (const FileFrame& frame : recording.frames) result.push_back(frame.color + "+" + frame.depth);
  return result;
}

TEST(ImageNames, OrderIsNumericWhateverTheNames) {
  const FileRecording recording = recording_of({{"IMG_10.JPG", "IMG_2.JPG", "IMG_1.JPG"}, {"d2.png", "d1.png", "d10.png"}, {}});
  EXPECT_THAT(pairs(recording), ElementsAre("IMG_1.JPG+d1.png", "IMG_2.JPG+d2.png", "IMG_10.JPG+d10.png"));
  EXPECT_EQ(recording.frames[2].number, 10);
  EXPECT_THAT(recording.assumed, IsEmpty());
}

TEST(ImageNames, DatesWithClockTimesCountAsAWhole) {
  const std::vector<std::string> names = {"2023-05-01_12-34-58.png", "2023-05-01_12-34-59.png", "2023-05-01_12-35-00.png"};
  EXPECT_THAT(pairs(recording_of({names, names, {}})),
              ElementsAre(names[0] + "+" + names[0], names[1] + "+" + names[1], names[2] + "+" + names[2]));
}

TEST(ImageNames, NumbersThatAreTheSameInAllNamesSayNothing) {
  EXPECT_THAT(pairs(recording_of({{"00000_cam1.jpg", "00001_cam1.jpg"}, {"00000_cam2.png", "00001_cam2.png"}, {}})),
              ElementsAre("00000_cam1.jpg+00000_cam2.png", "00001_cam1.jpg+00001_cam2.png"));
  EXPECT_THAT(pairs(recording_of({{"scene3_7.jpg", "scene3_8.jpg"}, {"7.png", "8.png"}, {}})),
              ElementsAre("scene3_7.jpg+7.png", "scene3_8.jpg+8.png"));
}

TEST(ImageNames, NumbersOfAnyLengthAndTimeStampsAreOrdered) {
  const std::vector<std::string> longer = {"20230501123450000009.png", "20230501123450000010.png"};
  EXPECT_THAT(pairs(recording_of({longer, longer, {}})), ElementsAre(longer[0] + "+" + longer[0], longer[1] + "+" + longer[1]));
  const std::vector<std::string> times = {"13.5.png", "13.25.png", "9.75.png"};
  const FileRecording timed = recording_of({times, times, {}});
  EXPECT_THAT(pairs(timed), ElementsAre("9.75.png+9.75.png", "13.25.png+13.25.png", "13.5.png+13.5.png"));
  EXPECT_DOUBLE_EQ(timed.frames[1].time_s, 13.25);
}

TEST(ImageNames, ListsThatWereCountedFromAnotherStartArePairedInOrderAndThatIsSaid) {
  const FileRecording recording = recording_of({{"0.jpg", "1.jpg", "2.jpg"}, {"1.png", "2.png", "3.png"}, {}});
  EXPECT_THAT(pairs(recording), ElementsAre("0.jpg+1.png", "1.jpg+2.png", "2.jpg+3.png"));
  EXPECT_THAT(recording.assumed, ElementsAre(HasSubstr("0.jpg and 1.png are the first): they are paired in their order")));
}

TEST(ImageNames, ImagesWithoutAPartnerKeepTheirPlace) {
  EXPECT_THAT(pairs(recording_of({{"0.jpg", "1.jpg", "2.jpg"}, {"0.png", "2.png"}, {}})),
              ElementsAre("0.jpg+0.png", "1.jpg+", "2.jpg+2.png"));
  EXPECT_THROW(recording_of({{"0.jpg", "1.jpg", "2.jpg"}, {"17.png", "18.png"}, {}}), Error);
}

TEST(ImageNames, PicturesForPeopleBesideTheImagesAreLeftOut) {
  EXPECT_THAT(pairs(recording_of({{"0.jpg", "1.jpg"}, {"0.png", "0_vis.png", "1.png", "1_vis.png"}, {}})),
              ElementsAre("0.jpg+0.png", "1.jpg+1.png"));
}

TEST(ImageNames, TwoFilesOfOnePlaceAreRefused) { EXPECT_THROW(recording_of({{"01.jpg", "1.jpg"}, {"1.png"}, {}}), Error); }

TEST(ImageNames, FilesAreTakenInAnyCaseAndHiddenOnesAreNone) {
  const std::filesystem::path root = fresh_folder("names");
  for (const char* name : {"a1.JPG", "a2.jpeg", "._a1.jpg", ".DS_Store", "Thumbs.db"}) write_text(root / "images" / name, "x");
  EXPECT_THAT(files_in(root, "images", kColorEndings), ElementsAre("images/a1.JPG", "images/a2.jpeg"));
}

}  // namespace
}  // namespace panoptic::test
