// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/bags/bag.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "panoptic/base/compression.h"
#include "panoptic/base/files.h"
#include "panoptic/base/sqlite.h"
#include "tests/bags/bag_bytes.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;
using namespace test;  // NOLINT(google-build-using-namespace): of the tests' own
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

const std::vector<WrittenMessage> kMessages = {{"/a", "std_msgs/String", 10, "first"},
                                               {"/b", "std_msgs/msg/Float32", 12, std::string(9000, 'b')},
                                               {"/a", "std_msgs/String", 11.5, "second"}};

std::string text_of(const BagBytes& bytes) { return {bytes.begin(), bytes.end()}; }

std::string error_of(const fs::path& path) {
  try {
    const Bag bag(path);
    return "no error";
  } catch (const Error& e) {
    return e.what();
  }
}

void expect_messages(const fs::path& path) {
  const Bag bag(path);
  ASSERT_EQ(bag.topics().size(), 2U);
  EXPECT_EQ(bag.topics()[0].name, "/a");
  EXPECT_EQ(bag.topics()[0].messages, 2U);
  EXPECT_EQ(bag.topics()[1].type, "std_msgs/Float32") << "that of ROS 2 has the name of ROS 1";
  ASSERT_EQ(bag.messages().size(), 3U);
  std::vector<std::string> texts;
  for (const BagMessage& m : bag.messages()) texts.push_back(text_of(bag.read(m)));
  EXPECT_THAT(texts, ElementsAre("first", "second", kMessages[1].bytes)) << "by time";
  EXPECT_EQ(text_of(bag.read(bag.messages()[2], 3)), "bbb");
  EXPECT_EQ(bag.messages()[1].time_ns, 11'500'000'000);
  EXPECT_THAT(bag.left_out(), IsEmpty());
}

TEST(Bag, GivesTheMessagesOfEachContainerByTime) {
  const fs::path folder = fresh_folder("bags");
  for (const bool is_indexed : {true, false}) {
    Ros1Fields fields;
    fields.is_indexed = is_indexed;
    write_file(folder / "a.bag", ros1_bag(kMessages, fields));
    expect_messages(folder / "a.bag");
    write_file(folder / "a.mcap", mcap_bag(kMessages, "", 0, is_indexed));
    expect_messages(folder / "a.mcap");
  }
}

TEST(Bag, CutOffAnywhereIsReadAsFarAsItGoes) {
  const fs::path folder = fresh_folder("cut");
  const std::vector<WrittenMessage> messages = {{"/a", "t/T", 1, "1"}, {"/a", "t/T", 2, "2"}};
  Ros1Fields plain;
  plain.is_indexed = false;
  constexpr std::size_t kPadding = 4000;  // at the beginning of ROS 1 bags
  for (const std::string& whole : {ros1_bag(messages), ros1_bag(messages, plain), mcap_bag(messages)}) {
    for (std::size_t n = 16; n<whole.size(); n += whole.size()> kPadding && n < kPadding ? 97 : 3) {
      write_file(folder / "a.bag", whole.substr(0, n));
      const Bag bag(folder / "a.bag");
      for (const BagMessage& m : bag.messages()) EXPECT_EQ(bag.read(m).size(), 1U);
    }
  }
  write_file(folder / "a.bag", ros1_bag(messages, plain).substr(0, ros1_bag(messages, plain).size() - 4));
  const Bag bag(folder / "a.bag");
  EXPECT_EQ(bag.messages().size(), 1U);
  EXPECT_THAT(bag.left_out(), Not(IsEmpty())) << "what was lost is told";
}

TEST(Bag, ChunksThatLieAboutTheirSizeAreLeftOut) {
  const fs::path folder = fresh_folder("lies");
  Ros1Fields fields;
  fields.size_more = 1U << 31;
  for (const char* compression : {"lz4", "bz2"}) {
    fields.compression = compression;
    fields.is_indexed = false;
    write_file(folder / "a.bag", ros1_bag(kMessages, fields));
    const Bag bag(folder / "a.bag");
    EXPECT_THAT(bag.messages(), IsEmpty());
    EXPECT_THAT(bag.left_out(), Not(IsEmpty()));
  }
  write_file(folder / "a.mcap", mcap_bag(kMessages, "zstd", std::uint64_t{1} << 62, false));
  EXPECT_THAT(Bag(folder / "a.mcap").left_out(), Not(IsEmpty()));
}

TEST(Bag, WhatUnpacksToMoreThanAnyRecordingHoldsIsRefused) {
  const fs::path path = fresh_folder("packed") / "a.mcap";
  const std::string message = mcap_record(5, std::string(22, '\0'));
  std::string chunk;
  for (std::uint64_t i = 0; i < most_messages(8000) + 1; ++i) chunk += message;
  const Bytes packed = Compressor().compress(std::span(reinterpret_cast<const std::uint8_t*>(chunk.data()), chunk.size()));
  ASSERT_LT(packed.size(), 7000U);
  const std::string head = std::string(16, '\0') + number_bytes(std::uint64_t{chunk.size()}) + number_bytes(std::uint32_t{0}) +
                           mcap_text("zstd") + number_bytes(std::uint64_t{packed.size()});
  write_file(path, kMcapMagic + mcap_record(1, mcap_text("ros2") + mcap_text("")) +
                       mcap_record(6, head + std::string(packed.begin(), packed.end())));
  EXPECT_THAT(error_of(path), HasSubstr("unpack to more than"));
}

TEST(Bag, MoreTopicsThanAnyRobotHasAreRefused) {
  const fs::path path = fresh_folder("topics") / "a.bag";
  std::string bag = kRos1Magic;
  for (std::uint32_t i = 0; i <= kMostConnections; ++i) {
    bag += ros1_record(ros1_fields({{"op", op(7)}, {"conn", number_bytes(i)}, {"topic", std::to_string(i)}}),
                       ros1_fields({{"type", "std_msgs/Empty"}}));
  }
  write_file(path, bag);
  EXPECT_THAT(error_of(path), HasSubstr("more than 10000 topics and publishers"));
}

TEST(Bag, DamagedMessagesAreRefusedWhenTheyAreRead) {
  const fs::path folder = fresh_folder("damaged");
  Ros1Fields fields;
  fields.compression = "lz4";  // which it is not
  write_file(folder / "a.bag", ros1_bag(kMessages, fields));
  const Bag bag(folder / "a.bag");
  ASSERT_EQ(bag.messages().size(), 3U);
  EXPECT_THROW(bag.read(bag.messages()[0]), Error);
}

TEST(Bag, UnknownCompressionIsRefusedByName) {
  const fs::path folder = fresh_folder("unknown");
  Ros1Fields fields;
  fields.compression = "rar";
  write_file(folder / "a.bag", ros1_bag(kMessages, fields));
  EXPECT_THAT(error_of(folder / "a.bag"), HasSubstr("compression 'rar'"));
  write_file(folder / "a.mcap", mcap_bag(kMessages, "secret"));
  EXPECT_THAT(error_of(folder / "a.mcap"), HasSubstr("compression 'secret'"));
}

TEST(Bag, PackedOrEncryptedAsAWholeIsRefusedWithTheRemedy) {
  const fs::path folder = fresh_folder("packed");
  write_file(folder / "a.bag", "\x1F\x8B\x08 and so on");
  EXPECT_THAT(error_of(folder / "a.bag"), HasSubstr("gunzip"));
  write_file(folder / "a.db3.zstd", "\x28\xB5\x2F\xFD and so on");
  EXPECT_TRUE(is_bag(folder / "a.db3.zstd"));
  EXPECT_THAT(error_of(folder / "a.db3.zstd"), HasSubstr("unzstd"));
  Ros1Fields fields;
  fields.encryptor = "rosbag/AesCbcEncryptor";
  write_file(folder / "a.bag", ros1_bag(kMessages, fields));
  EXPECT_THAT(error_of(folder / "a.bag"), HasSubstr("rosbag decrypt"));
  write_file(folder / "a.bag", "#ROSBAG V1.2\n and so on");
  EXPECT_THAT(error_of(folder / "a.bag"), HasSubstr("rosbag fix"));
  write_file(folder / "a.bag", "nothing of the kind");
  EXPECT_THAT(error_of(folder / "a.bag"), HasSubstr("neither a ROS 1 bag nor"));
  write_file(folder / "a.bag", "");
  EXPECT_THAT(error_of(folder / "a.bag"), HasSubstr("empty"));
}

TEST(Bag, PartsInAFolderAreOneUnlessTheyAreOfOtherTimes) {
  const fs::path folder = fresh_folder("parts");
  write_file(folder / "a_0.bag", ros1_bag({kMessages[0]}));
  write_file(folder / "a_1.bag", ros1_bag({kMessages[1], kMessages[2]}));
  expect_messages(folder);
  write_file(folder / "b.bag", ros1_bag({{"/a", "std_msgs/String", 5000, "another day"}}));
  EXPECT_THAT(error_of(folder), HasSubstr("no parts of one bag"));
}

TEST(Bag, ACopyOfABagBesideItIsNoPartOfIt) {
  const fs::path folder = fresh_folder("copies");
  const auto images = [](double begin_s) {
    std::vector<WrittenMessage> messages;
    for (int i = 0; i < 4; ++i) {
      messages.push_back({"/d", "sensor_msgs/Image", begin_s + 0.1 * i, image_bytes({begin_s + 0.1 * i})});
      messages.push_back({"/tf", "tf2_msgs/TFMessage", begin_s + 0.1 * i, transform_bytes(begin_s, "map", "camera", {0, 0, 0})});
    }
    return messages;
  };
  write_file(folder / "a_0.bag", ros1_bag(images(10)));
  write_file(folder / "a_1.bag", ros1_bag(images(10.25)));
  EXPECT_EQ(Bag(folder).messages().size(), 16U) << "one image too early at the seam";
  write_file(folder / "a_1.bag", ros1_bag(images(10)));
  EXPECT_THAT(error_of(folder), HasSubstr("a_0.bag and a_1.bag hold images of one topic at one time"));
}

TEST(Bag, AMapFileIsNone) {
  const fs::path folder = fresh_folder("databases");
  Database(folder / "map.panoptic", DatabaseAccess::kCreate).execute("CREATE TABLE meta(key TEXT)");
  EXPECT_FALSE(is_bag(folder / "map.panoptic"));
  Database(folder / "bag.sqlite", DatabaseAccess::kCreate).execute("CREATE TABLE topics(id); CREATE TABLE messages(id)");
  EXPECT_TRUE(is_bag(folder / "bag.sqlite")) << "by its tables";
  fs::copy(folder / "map.panoptic", folder / "odd.db3");
  EXPECT_THAT(error_of(folder / "odd.db3"), HasSubstr("no tables of topics and messages"));
}

}  // namespace
}  // namespace panoptic
