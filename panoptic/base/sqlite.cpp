// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/sqlite.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>

#include "panoptic/base/files.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr int kMostBytesOfValue = 1 << 29;
constexpr int kPatience_ms = 5000;  // while another process writes

std::string remedy_for(int code, const std::string& kind) {
  switch (code & 0xFF) {
    case SQLITE_FULL:
      return "free space on the disk";
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return "another process is writing it: wait until it is done";
    case SQLITE_CANTOPEN:
      return "check the path, the permissions of its folder and the space on the disk";
    case SQLITE_READONLY:
    case SQLITE_PERM:
      // So SQLite also says where it could not write its log, or not learn whether the file was moved.
      return "check that the disk is neither full nor read-only, and the permissions of the file and its folder";
    case SQLITE_IOERR:
      return "check the disk and the space on it";
    case SQLITE_NOMEM:
      return "there is not enough memory";
    default:
      return fmt::format("the file is damaged or no {}: use another copy", kind == "map file" ? "map" : kind);
  }
}

int flags_of(DatabaseAccess access, const std::filesystem::path& path) {
  if (access == DatabaseAccess::kRead) {
    // A journal is of a program that ended while it changed the file: SQLite must undo the change before it can be read.
    return is_there(path.string() + "-journal") ? SQLITE_OPEN_READWRITE : SQLITE_OPEN_READONLY;
  }
  return access == DatabaseAccess::kWrite ? SQLITE_OPEN_READWRITE : SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
}

// A file may hold statements that were put there to do harm when something is read or written.
void harden(sqlite3* handle) {
  for (const int option : {SQLITE_DBCONFIG_DEFENSIVE, SQLITE_DBCONFIG_ENABLE_TRIGGER, SQLITE_DBCONFIG_TRUSTED_SCHEMA,
                           SQLITE_DBCONFIG_ENABLE_LOAD_EXTENSION, SQLITE_DBCONFIG_DQS_DDL, SQLITE_DBCONFIG_DQS_DML}) {
    sqlite3_db_config(handle, option, option == SQLITE_DBCONFIG_DEFENSIVE ? 1 : 0, nullptr);
  }
  sqlite3_limit(handle, SQLITE_LIMIT_LENGTH, kMostBytesOfValue);
  sqlite3_limit(handle, SQLITE_LIMIT_ATTACHED, 0);
  sqlite3_busy_timeout(handle, kPatience_ms);
  sqlite3_extended_result_codes(handle, 1);
}

// The errno with which the system last refused something, on the file or on the log or journal beside it; 0 if it did not.
int disk_errno(sqlite3* handle) {
  for (const int which : {SQLITE_FCNTL_FILE_POINTER, SQLITE_FCNTL_JOURNAL_POINTER}) {
    sqlite3_file* file = nullptr;
    int reason = 0;
    if (sqlite3_file_control(handle, nullptr, which, static_cast<void*>(&file)) != SQLITE_OK) continue;
    if (file == nullptr || file->pMethods == nullptr || file->pMethods->xFileControl == nullptr) continue;  // as in memory
    if (file->pMethods->xFileControl(file, SQLITE_FCNTL_LAST_ERRNO, &reason) == SQLITE_OK && reason != 0) return reason;
  }
  return 0;
}

// The system's reason for a failure with this code, where SQLite still knows it: having failed to open a file it looks for
// others, whose absence is none. 0: it does not.
int refused_with(sqlite3* handle, int code) {
  const int kind = code & 0xFF;
  if (kind != SQLITE_CANTOPEN && kind != SQLITE_IOERR) return 0;
  const int reason = sqlite3_system_errno(handle);
  return reason == ENOENT ? 0 : reason;
}

}  // namespace

void Database::Close::operator()(sqlite3* handle) const { sqlite3_close_v2(handle); }

Database::Database(const std::filesystem::path& path, DatabaseAccess access, std::string_view kind) : path_(path), kind_(kind) {
  const bool in_memory = path == ":memory:";
  if (access == DatabaseAccess::kCreate && !in_memory && is_there(path)) {
    throw Error(fmt::format("{} is there already; choose another name or remove it", path.string()));
  }
  if (access != DatabaseAccess::kCreate && !is_file(path)) {
    const char* why =
        is_folder(path) ? "it is a folder; give the path of the file in it" : "there is no such file; check the path";
    throw Error(fmt::format("cannot open {}: {}", path.string(), why));
  }
  sqlite3* handle = nullptr;
  const int code = sqlite3_open_v2(path.c_str(), &handle, flags_of(access, path) | SQLITE_OPEN_NOMUTEX, nullptr);
  handle_.reset(handle);
  if (handle == nullptr) throw std::bad_alloc();
  if (code != SQLITE_OK) fail();
  harden(handle);
  execute("PRAGMA cell_size_check = ON; PRAGMA mmap_size = 0;");
}

void Database::fail() const {
  const int code = sqlite3_extended_errcode(handle_.get());
  const char* words = sqlite3_errmsg(handle_.get());
  require_disk(words);
  const int reason = refused_with(handle_.get(), code);
  throw Error(fmt::format("{} {}: {}{}; {}", kind_, path_.string(), words,
                          reason != 0 ? fmt::format(" ({})", os::reason(reason)) : "", remedy_for(code, kind_)));
}

// SQLite takes a page that the disk would not give for a damaged one, and would have the user throw a good file away.
void Database::require_disk(std::string_view words) const {
  const int reason = disk_errno(handle_.get());
  if (reason == 0) return;
  throw FileError(
      fmt::format("{} {}: {} ({}); check the disk and the space on it", kind_, path_.string(), words, os::reason(reason)));
}

void Database::refuse(std::string_view what) const { throw Error(fmt::format("{} {}: {}", kind_, path_.string(), what)); }

void Database::execute(const char* sql) {
  if (sqlite3_exec(handle_.get(), sql, nullptr, nullptr, nullptr) != SQLITE_OK) fail();
}

std::int64_t Database::integer(const char* sql) {
  Statement statement(*this, sql);
  if (!statement.step()) refuse("a value is missing; the file is damaged: use another copy");
  return statement.integer(0);
}

std::string Database::text(const char* sql) {
  Statement statement(*this, sql);
  if (!statement.step()) refuse("a value is missing; the file is damaged: use another copy");
  return std::string(statement.text(0));
}

std::optional<std::vector<std::uint8_t>> Database::blob(const char* table, const char* column, std::int64_t row,
                                                        std::size_t at_most) const {
  sqlite3_blob* opened = nullptr;
  const int code = sqlite3_blob_open(handle_.get(), "main", table, column, row, 0, &opened);
  const std::unique_ptr<sqlite3_blob, decltype(&sqlite3_blob_close)> blob(opened, &sqlite3_blob_close);
  if (code == SQLITE_ERROR) return std::nullopt;
  if (code != SQLITE_OK) fail();
  std::vector<std::uint8_t> bytes(std::min(at_most, static_cast<std::size_t>(sqlite3_blob_bytes(opened))));
  if (sqlite3_blob_read(opened, bytes.data(), static_cast<int>(bytes.size()), 0) != SQLITE_OK) fail();
  return bytes;
}

void Statement::Finalize::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

Statement::Statement(const Database& database, std::string_view sql) : database_(database) {
  sqlite3_stmt* statement = nullptr;
  const int code = sqlite3_prepare_v2(database.handle(), sql.data(), static_cast<int>(sql.size()), &statement, nullptr);
  statement_.reset(statement);
  if (code != SQLITE_OK) database_.fail();
}

void Statement::check(int code) const {
  if (code != SQLITE_OK) database_.fail();
}

Statement& Statement::bind(std::int64_t value) {
  check(sqlite3_bind_int64(statement_.get(), ++bound_, value));
  return *this;
}

Statement& Statement::bind(double value) {
  check(sqlite3_bind_double(statement_.get(), ++bound_, value));
  return *this;
}

Statement& Statement::bind(std::string_view text) {
  check(sqlite3_bind_text64(statement_.get(), ++bound_, text.data(), text.size(), SQLITE_TRANSIENT, SQLITE_UTF8));
  return *this;
}

Statement& Statement::bind(std::span<const std::uint8_t> bytes) {
  // An empty span may have no address, which would bind NULL.
  const void* address = bytes.empty() ? static_cast<const void*>("") : bytes.data();
  check(sqlite3_bind_blob64(statement_.get(), ++bound_, address, bytes.size(), SQLITE_TRANSIENT));
  return *this;
}

Statement& Statement::bind_null() {
  check(sqlite3_bind_null(statement_.get(), ++bound_));
  return *this;
}

bool Statement::step() {
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  // Also after a failure: it may be tried again. What failed stays known to the connection.
  sqlite3_reset(statement_.get());
  sqlite3_clear_bindings(statement_.get());
  bound_ = 0;
  if (code != SQLITE_DONE) database_.fail();
  return false;
}

void Statement::require_type(int column, int type) const {
  if (sqlite3_column_type(statement_.get(), column) == type) return;
  database_.refuse(fmt::format("column {} of {} has a value of the wrong type; the file is damaged: use another copy",
                               sqlite3_column_name(statement_.get(), column), sqlite3_sql(statement_.get())));
}

bool Statement::is_null(int column) const { return sqlite3_column_type(statement_.get(), column) == SQLITE_NULL; }

std::int64_t Statement::integer(int column) const {
  require_type(column, SQLITE_INTEGER);
  return sqlite3_column_int64(statement_.get(), column);
}

std::int64_t Statement::integer(int column, std::int64_t min, std::int64_t max) const {
  const std::int64_t value = integer(column);
  if (value >= min && value <= max) return value;
  database_.refuse(fmt::format("column {} of {} holds {}, which is not between {} and {}; the file is damaged: use another copy",
                               sqlite3_column_name(statement_.get(), column), sqlite3_sql(statement_.get()), value, min, max));
}

double Statement::real(int column) const {
  require_type(column, SQLITE_FLOAT);
  return sqlite3_column_double(statement_.get(), column);
}

std::string_view Statement::text(int column) const {
  require_type(column, SQLITE_TEXT);
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_.get(), column));
  if (text == nullptr) throw std::bad_alloc();
  return {text, static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column))};
}

std::span<const std::uint8_t> Statement::bytes(int column) const {
  require_type(column, SQLITE_BLOB);
  const auto* bytes = static_cast<const std::uint8_t*>(sqlite3_column_blob(statement_.get(), column));
  return {bytes, static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column))};
}

Transaction::Transaction(Database& database, bool writes) : database_(database) {
  database_.execute(writes ? "BEGIN IMMEDIATE" : "BEGIN");
}

Transaction::~Transaction() {
  // SQLite undid it by itself after some errors; there is nobody to tell of another.
  if (open_) sqlite3_exec(database_.handle(), "ROLLBACK", nullptr, nullptr, nullptr);
}

void Transaction::commit() {
  database_.execute("COMMIT");
  open_ = false;
}

}  // namespace panoptic
