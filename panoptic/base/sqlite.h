// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The seam to SQLite: a connection that trusts no file, and prepared statements. Every failure is an Error with the file's name.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

struct sqlite3;
struct sqlite3_stmt;

namespace panoptic {

enum class DatabaseAccess { kRead, kWrite, kCreate };  // kCreate: fails if there is anything of that name

// One thread at a time.
class Database {
 public:
  // ":memory:" is a database of its own. `kind` is what the file is to its user, for messages.
  Database(const std::filesystem::path& path, DatabaseAccess access, std::string_view kind = "map file");
  ~Database() = default;

  const std::filesystem::path& path() const { return path_; }
  void execute(const char* sql);          // several statements without parameters and results
  std::int64_t integer(const char* sql);  // the one value that it gives
  std::string text(const char* sql);
  // The first bytes of a blob, without reading the rest; nothing if there is no such row, or no blob in it.
  std::optional<std::vector<std::uint8_t>> blob(const char* table, const char* column, std::int64_t row,
                                                std::size_t at_most) const;
  sqlite3* handle() const { return handle_.get(); }

  // Throws an Error with the reason why the last call on the connection failed.
  [[noreturn]] void fail() const;
  // Throws an Error: the file is not what it should be.
  [[noreturn]] void refuse(std::string_view what) const;
  // Throws FileError if the disk failed to give or take a part of the file: the fault that was found (`words`) is then not the
  // file's.
  void require_disk(std::string_view words) const;

 private:
  struct Close {
    void operator()(sqlite3* handle) const;
  };
  std::filesystem::path path_;
  std::string kind_;
  std::unique_ptr<sqlite3, Close> handle_;
};

// Parameters are bound in order; columns count from 0. A value of another type than asked for is refused.
class Statement {
 public:
  Statement(const Database& database, std::string_view sql);

  Statement& bind(std::int64_t value);
  Statement& bind(double value);  // NaN becomes NULL
  Statement& bind(std::string_view text);
  Statement& bind(std::span<const std::uint8_t> bytes);
  Statement& bind_null();

  // The next row, if there is one; after the last one the statement can be bound anew, and what is not
  // bound is NULL.
  bool step();
  void run() { step(); }  // of a statement without rows

  bool is_null(int column) const;
  std::int64_t integer(int column) const;
  // Refuses a value outside [min, max].
  std::int64_t integer(int column, std::int64_t min, std::int64_t max) const;
  double real(int column) const;
  // The text in a column, valid until the next step.
  std::string_view text(int column) const;
  std::span<const std::uint8_t> bytes(int column) const;

 private:
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };
  void require_type(int column, int type) const;
  void check(int code) const;

  const Database& database_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
  int bound_ = 0;
};

// All or nothing: what was not committed when it ends is undone.
class Transaction {
 public:
  // `writes`: takes the write lock at once; else everything is read as of the first read.
  explicit Transaction(Database& database, bool writes = true);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void commit();

 private:
  Database& database_;
  bool open_ = true;
};

}  // namespace panoptic
