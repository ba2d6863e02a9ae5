// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/files.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <csignal>
#include <fstream>

#include "tests/expect_error.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

using test::error_of;
using test::fresh_folder;
using testing::ElementsAre;
using testing::HasSubstr;

std::vector<std::string> names_in(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

// Acts as an ordinary user for its life, if the tests run as root: root may write everywhere.
class OrdinaryUser {
 public:
  OrdinaryUser() : was_root_(::geteuid() == 0 && ::seteuid(kNobody) == 0) {}
  ~OrdinaryUser() {
    if (was_root_ && ::seteuid(0) != 0) std::abort();
  }
  OrdinaryUser(const OrdinaryUser&) = delete;
  OrdinaryUser& operator=(const OrdinaryUser&) = delete;

 private:
  static constexpr uid_t kNobody = 65534;
  bool was_root_;
};

TEST(ReadFile, GivesEveryByte) {
  const std::filesystem::path folder = fresh_folder();
  std::string bytes(100001, '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * 31);
  std::ofstream(folder / "file", std::ios::binary) << bytes;
  EXPECT_EQ(read_file(folder / "file"), bytes);
  std::ofstream(folder / "empty").flush();
  EXPECT_EQ(read_file(folder / "empty"), "");
}

TEST(ReadFile, NamesAnAbsentFile) {
  EXPECT_THAT(error_of([] { read_file("/nowhere/file"); }), HasSubstr("cannot read /nowhere/file: No such file"));
}

TEST(ReadFile, RefusesWhatIsNoRegularFileAtOnce) {
  const std::filesystem::path folder = fresh_folder();
  EXPECT_THAT(error_of([&] { read_file(folder); }), HasSubstr("not a regular file"));
  EXPECT_THAT(error_of([] { read_file("/dev/zero"); }), HasSubstr("not a regular file"));
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_THAT(error_of([&] { read_file(folder / "pipe"); }), HasSubstr("not a regular file"));  // and does not wait for a writer
}

TEST(ReadFile, ChecksTheSizeBeforeItTakesMemory) {
  const std::filesystem::path folder = fresh_folder();
  std::ofstream(folder / "sparse").flush();
  std::filesystem::resize_file(folder / "sparse", std::uintmax_t{1} << 40);  // 1 TiB of nothing
  EXPECT_THAT(error_of([&] { read_file(folder / "sparse"); }), HasSubstr("1099511627776 bytes, more than the limit"));
  std::filesystem::resize_file(folder / "sparse", 10);
  EXPECT_EQ(read_file(folder / "sparse", 10).size(), 10U);
  error_of([&] { read_file(folder / "sparse", 9); });
}

TEST(ReadFile, NamesAFileThatItMayNotRead) {
  const std::filesystem::path folder = fresh_folder();
  write_file(folder / "secret", "x");
  std::filesystem::permissions(folder / "secret", std::filesystem::perms::none);
  const OrdinaryUser ordinary;
  EXPECT_THAT(error_of([&] { read_file(folder / "secret"); }), HasSubstr("Permission denied"));
}

TEST(WriteFile, WritesAndReplaces) {
  const std::filesystem::path folder = fresh_folder();
  write_file(folder / "file", "first, longer");
  write_file(folder / "file", "second");
  EXPECT_EQ(read_file(folder / "file"), "second");
  const std::vector<std::uint8_t> bytes = {0, 255, 10};
  write_file(folder / "bytes", bytes);
  EXPECT_EQ(read_file(folder / "bytes"), std::string("\0\xff\n", 3));
  EXPECT_THAT(names_in(folder), ElementsAre("bytes", "file"));  // no temporary file stays
}

TEST(WriteFile, ReadersSeeTheOldOrTheNewFileAndNothingBetween) {
  const std::filesystem::path folder = fresh_folder();
  const std::string even(1 << 20, 'e');
  const std::string odd(1 << 19, 'o');
  write_file(folder / "file", even);
  const pid_t writer = ::fork();
  if (writer == 0) {
    for (int i = 0; i < 20; ++i) write_file(folder / "file", i % 2 == 0 ? odd : even);
    ::_exit(0);
  }
  int status = 0;
  while (::waitpid(writer, &status, WNOHANG) == 0) {
    const std::string seen = read_file(folder / "file");
    ASSERT_TRUE(seen == even || seen == odd) << seen.size();
  }
  EXPECT_EQ(status, 0);
}

TEST(WriteFile, AFailureLeavesTheOldFileAndNoRemains) {
  const std::filesystem::path folder = fresh_folder();
  write_file(folder / "file", "old");
  const pid_t child = ::fork();  // the limit and the signal's fate are the process's
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1 << 16, 1 << 16};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    try {
      write_file(folder / "file", std::string(1 << 20, 'n'));
    } catch (const Error& error) {
      ::_exit(std::string(error.what()).find("File too large") != std::string::npos ? 0 : 2);
    }
    ::_exit(1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(read_file(folder / "file"), "old");
  EXPECT_THAT(names_in(folder), ElementsAre("file"));
}

TEST(WriteFile, AFullDiskLeavesTheOldFileAndNoRemains) {
  const std::filesystem::path folder = fresh_folder();
  std::filesystem::create_directory(folder / "disk");
  if (::mount("tmpfs", (folder / "disk").c_str(), "tmpfs", 0, "size=256k") != 0)
    GTEST_SKIP() << "needs the right to mount a tmpfs";
  const std::filesystem::path file = folder / "disk/file";
  write_file(file, "old");
  const std::string message = error_of([&] { write_file(file, std::string(1 << 20, 'n')); });
  EXPECT_THAT(message, HasSubstr("No space left on device; free space"));
  EXPECT_EQ(read_file(file), "old");
  EXPECT_THAT(names_in(folder / "disk"), ElementsAre("file"));
  EXPECT_EQ(::umount((folder / "disk").c_str()), 0);
}

TEST(WriteFile, NamesTheTargetWhenTheFolderIsAbsentOrForbidden) {
  const std::filesystem::path folder = fresh_folder();
  EXPECT_THAT(error_of([&] { write_file(folder / "absent/file", "x"); }), HasSubstr("absent/file: No such file"));
  std::filesystem::permissions(folder, std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  {
    const OrdinaryUser ordinary;
    EXPECT_THAT(error_of([&] { write_file(folder / "file", "x"); }), HasSubstr("Permission denied"));
  }
  std::filesystem::permissions(folder, std::filesystem::perms::owner_all);
}

TEST(WriteFile, DoesNotReplaceAFolder) {
  const std::filesystem::path folder = fresh_folder();
  std::filesystem::create_directory(folder / "taken");
  EXPECT_THAT(error_of([&] { write_file(folder / "taken", "x"); }), HasSubstr("Is a directory"));
  EXPECT_THAT(names_in(folder), ElementsAre("taken"));
}

TEST(RequireWritableFolder, MakesParentsAndLeavesNothingBehind) {
  const std::filesystem::path folder = fresh_folder();
  require_writable_folder(folder / "a/b/c");
  require_writable_folder(folder / "a/b/c");
  EXPECT_TRUE(std::filesystem::is_empty(folder / "a/b/c"));
}

TEST(RequireWritableFolder, RefusesAFileInTheWay) {
  const std::filesystem::path folder = fresh_folder();
  write_file(folder / "file", "x");
  EXPECT_THAT(error_of([&] { require_writable_folder(folder / "file"); }), HasSubstr("cannot create the folder"));
  EXPECT_THAT(error_of([&] { require_writable_folder(folder / "file/sub"); }), HasSubstr("cannot create the folder"));
}

TEST(RequireWritableFolder, RefusesAFolderWithoutPermission) {
  const std::filesystem::path folder = fresh_folder();
  std::filesystem::create_directory(folder / "locked");
  std::filesystem::permissions(folder / "locked", std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  {
    const OrdinaryUser ordinary;
    EXPECT_THAT(error_of([&] { require_writable_folder(folder / "locked"); }), HasSubstr("Permission denied"));
    EXPECT_THAT(error_of([&] { require_writable_folder(folder / "locked/sub"); }), HasSubstr("Permission denied"));
  }
  std::filesystem::permissions(folder / "locked", std::filesystem::perms::owner_all);
}

TEST(PartialFile, AppearsWholeWithCommitOnly) {
  const std::filesystem::path folder = fresh_folder();
  {
    PartialFile file(folder / "file");
    file.append("0123");
    file.append("4567");
    file.overwrite(2, "xy");
    file.append("89");
    EXPECT_FALSE(is_there(folder / "file"));
    file.commit();
  }
  EXPECT_EQ(read_file(folder / "file"), "01xy456789");
  { PartialFile(folder / "file").append("newer"); }
  EXPECT_EQ(read_file(folder / "file"), "01xy456789") << "never committed";
  EXPECT_THAT(names_in(folder), ElementsAre("file"));
}

TEST(PartialFile, SaysThatTheDiskIsFull) {
  if (!is_there("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  const std::filesystem::path folder = fresh_folder();
  // Its temporary name leads to a disk that is always full.
  std::filesystem::create_symlink("/dev/full", folder / fmt::format(".file.{}.partial", ::getpid()));
  EXPECT_THAT(error_of([&] { write_file(folder / "file", "x"); }), HasSubstr("No space left on device"));
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

TEST(Names, OfAFolderAreSortedAndOfNothingThereAreNone) {
  const std::filesystem::path folder = fresh_folder();
  for (const char* name : {"b", "a", "c"}) write_file(folder / name, "");
  EXPECT_THAT(names_in_folder(folder), ElementsAre("a", "b", "c"));
  EXPECT_TRUE(names_in_folder(folder / "a").empty());
  EXPECT_TRUE(names_in_folder(folder / "no").empty());
}

TEST(Names, WhatCannotBeLookedAtIsNotAbsent) {
  const std::filesystem::path folder = fresh_folder();
  std::filesystem::create_directory(folder / "secret");
  write_file(folder / "secret" / "file", "");
  std::filesystem::create_symlink("nowhere", folder / "link");
  EXPECT_TRUE(is_there(folder / "secret" / "file") && is_file(folder / "secret" / "file") && is_folder(folder / "secret"));
  EXPECT_TRUE(is_there(folder / "link")) << "a link to nowhere is in the way too";
  EXPECT_FALSE(is_file(folder / "link"));
  std::filesystem::permissions(folder / "secret", std::filesystem::perms::none);
  {
    const OrdinaryUser ordinary;
    EXPECT_THAT(error_of([&] { is_there(folder / "secret" / "file"); }), HasSubstr("Permission denied"));
    EXPECT_THAT(error_of([&] { names_in_folder(folder / "secret"); }), HasSubstr("Permission denied"));
  }
  std::filesystem::permissions(folder / "secret", std::filesystem::perms::all);
}

}  // namespace
}  // namespace panoptic
