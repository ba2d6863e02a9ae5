// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/category_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <vector>

#include "panoptic/base/files.h"
#include "panoptic/error.h"

namespace panoptic {
namespace {

constexpr std::uintmax_t kMaxTsvBytes = std::uintmax_t{16} << 20;

std::string squeezed(std::string_view name) {
  std::string text;
  for (const char c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) text += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return text;
}

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  while (true) {
    const std::size_t tab = line.find('\t');
    cells.push_back(line.substr(0, tab));
    if (tab == std::string_view::npos) return cells;
    line.remove_prefix(tab + 1);
  }
}

// A table of text, line by line.
class Tsv {
 public:
  Tsv(const std::filesystem::path& path, std::string_view text) : name_(path.string()), rest_(text) {}

  [[noreturn]] void fail(const std::string& what) const { throw Error(fmt::format("{}:{}: {}", name_, line_, what)); }

  // False at the end of the file.
  bool next(std::vector<std::string_view>& cells) {
    if (rest_.empty()) return false;
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    cells = cells_of(line);
    ++line_;
    return true;
  }

 private:
  std::string name_;
  std::string_view rest_;
  std::size_t line_ = 0;
};

std::size_t column(const std::vector<std::string_view>& header, std::string_view name, const Tsv& tsv) {
  const auto at = std::find(header.begin(), header.end(), name);
  if (at == header.end()) {
    tsv.fail(fmt::format("no column '{}'; expected ScanNet's scannetv2-labels.combined.tsv, tab separated", name));
  }
  return static_cast<std::size_t>(at - header.begin());
}

ClassId class_in(std::string_view cell, const Tsv& tsv) {
  if (cell.empty()) return ClassId::kUnknown;
  std::uint16_t id = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), id);
  if (error != std::errc() || end != cell.data() + cell.size() || id > kNyu40Classes) {
    tsv.fail(fmt::format("'{}' is no NYU40 class; expected a number from 0 to {}", cell, kNyu40Classes));
  }
  return static_cast<ClassId>(id);
}

}  // namespace

std::string_view nyu40_name(ClassId id) {
  const std::uint16_t n = number(id);
  return n >= 1 && n <= kNyu40Classes ? kNyu40Names[n - 1U] : "unknown";
}

ClassId nyu40_class(std::string_view name) {
  static const std::map<std::string, ClassId, std::less<>> kClasses = [] {
    std::map<std::string, ClassId, std::less<>> classes;
    for (std::uint16_t n = 1; n <= kNyu40Classes; ++n) classes[squeezed(kNyu40Names[n - 1U])] = static_cast<ClassId>(n);
    classes["furniture"] = classes.at("otherfurniture");    // ScanNet's raw category for it
    classes["refridgerator"] = classes.at("refrigerator");  // as many lists spell it
    return classes;
  }();
  const auto at = kClasses.find(squeezed(name));
  return at == kClasses.end() ? ClassId::kUnknown : at->second;
}

CategoryMap::CategoryMap(const std::filesystem::path& tsv) : from_file_(true) {
  const std::string text = read_file(tsv, kMaxTsvBytes);
  Tsv table(tsv, text);
  std::vector<std::string_view> cells;
  if (!table.next(cells)) throw Error(fmt::format("{}: empty; expected a header line and one line per category", tsv.string()));
  const std::size_t raw = column(cells, "raw_category", table);
  const std::size_t nyu40 = column(cells, "nyu40id", table);
  const std::size_t columns = cells.size();
  while (table.next(cells)) {
    if (cells.size() == 1 && cells.front().empty()) continue;
    if (cells.size() <= std::max(raw, nyu40)) table.fail(fmt::format("{} of {} columns", cells.size(), columns));
    classes_.insert_or_assign(std::string(cells[raw]), class_in(cells[nyu40], table));
  }
}

ClassId CategoryMap::nyu40(std::string_view raw_label) const {
  if (!from_file_) return nyu40_class(raw_label);
  const auto at = classes_.find(raw_label);
  return at == classes_.end() ? ClassId::kUnknown : at->second;
}

bool CategoryMap::knows(std::string_view raw_label) const {
  return from_file_ ? classes_.contains(raw_label) : nyu40_class(raw_label) != ClassId::kUnknown;
}

}  // namespace panoptic
