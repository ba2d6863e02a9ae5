// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/sqlite.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/expect_error.h"
#include "tests/fresh_folder.h"

namespace panoptic {
namespace {

// The journal of a database in memory is in memory too, and no disk is behind it that could be asked.
TEST(Database, AFailureWithinATransactionIsAnErrorWhereverTheDatabaseIs) {
  for (const std::filesystem::path& path : {std::filesystem::path(":memory:"), test::fresh_folder("database") / "a.panoptic"}) {
    Database database(path, DatabaseAccess::kCreate);
    database.execute("CREATE TABLE numbers(n INTEGER CHECK(n < 9)); BEGIN; INSERT INTO numbers VALUES(1)");
    const std::string error = test::error_of([&] { database.execute("INSERT INTO numbers VALUES(10)"); });
    EXPECT_NE(error.find("CHECK constraint failed"), std::string::npos) << error;
    database.execute("COMMIT");
    EXPECT_EQ(database.integer("SELECT count(*) FROM numbers"), 1);
  }
}

TEST(Database, WhatIsNoFileIsNamed) {
  const std::filesystem::path folder = test::fresh_folder("database");
  const std::string of_folder = test::error_of([&] { const Database database(folder, DatabaseAccess::kRead); });
  EXPECT_NE(of_folder.find("it is a folder"), std::string::npos) << of_folder;
  const std::string of_nothing = test::error_of([&] { const Database database(folder / "a", DatabaseAccess::kRead); });
  EXPECT_NE(of_nothing.find("there is no such file"), std::string::npos) << of_nothing;
}

}  // namespace
}  // namespace panoptic
