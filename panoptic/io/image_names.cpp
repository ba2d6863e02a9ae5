// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/image_names.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <map>
#include <set>

#include "panoptic/base/files.h"
#include "panoptic/base/text.h"
#include "panoptic/error.h"
#include "panoptic/io/dataset_text.h"

namespace panoptic {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kDigits = "0123456789";
constexpr std::size_t kWholeDigits = 40;  // padded to so many, numbers sort as text
constexpr std::size_t kNanoDigits = 9;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::string stem_of(const std::string& path) { return fs::path(path).stem().string(); }

// The numbers of a name, each padded so that text order is numeric order: "12" and "1305031102.175304".
std::vector<std::string> numbers_of(const std::string& stem) {
  std::vector<std::string> numbers;
  for (std::size_t at = stem.find_first_of(kDigits); at != std::string::npos; at = stem.find_first_of(kDigits, at)) {
    const std::size_t end = std::min(stem.find_first_not_of(kDigits, at), stem.size());
    std::string whole = stem.substr(at, end - at);
    whole.erase(0, std::min(whole.find_first_not_of('0'), whole.size() - 1));
    if (whole.size() < kWholeDigits) whole.insert(0, kWholeDigits - whole.size(), '0');
    at = end;
    if (end + 1 < stem.size() && stem[end] == '.' && is_digit(stem[end + 1])) {
      at = std::min(stem.find_first_not_of(kDigits, end + 1), stem.size());
      std::string fraction = stem.substr(end, at - end);
      fraction.resize(std::max(fraction.size(), kNanoDigits + 1), '0');
      whole += fraction;
    }
    numbers.push_back(std::move(whole));
  }
  return numbers;
}

// The name without its numbers: names of one form differ in numbers alone.
std::string form_of_name(const std::string& stem) {
  std::string form;
  for (const char c : stem) {
    if (!is_digit(c)) form += c;
    if (is_digit(c) && !form.ends_with('#')) form += '#';
  }
  return form;
}

// One kind of file with the numbers of each name.
struct NumberedNames {
  std::vector<std::string> paths;
  std::vector<std::vector<std::string>> numbers;

  std::size_t count() const { return numbers.empty() ? 0 : numbers.front().size(); }  // of numbers in a name
  bool uniform() const {
    return std::all_of(numbers.begin(), numbers.end(), [&](const auto& n) { return n.size() == count(); }) &&
           std::set(numbers.begin(), numbers.end()).size() == numbers.size();
  }
  bool varies(std::size_t i) const {
    return std::any_of(numbers.begin(), numbers.end(), [&](const auto& n) { return n[i] != numbers.front()[i]; });
  }
};

// Names without a number have no place.
NumberedNames with_numbers(const std::vector<std::string>& paths) {
  NumberedNames names;
  for (const std::string& path : paths) {
    std::vector<std::string> numbers = numbers_of(stem_of(path));
    if (numbers.empty()) continue;
    names.paths.push_back(path);
    names.numbers.push_back(std::move(numbers));
  }
  return names;
}

// Files of one form of name where not all have the same: the form that most have, and of several such the one that `other` has.
NumberedNames of_one_form(const NumberedNames& names, const NumberedNames& other) {
  std::map<std::string, std::vector<std::string>> by_form;
  for (const std::string& path : names.paths) by_form[form_of_name(stem_of(path))].push_back(path);
  std::size_t most = 0;
  for (const auto& [form, paths] : by_form) most = std::max(most, paths.size());
  const std::string preferred = other.paths.empty() ? "" : form_of_name(stem_of(other.paths.front()));
  const auto same = by_form.find(preferred);
  auto best = same != by_form.end() && same->second.size() == most ? same : by_form.begin();
  while (best->second.size() != most) ++best;
  return with_numbers(best->second);
}

// Drops the numbers that say nothing. Lists whose names hold equally many keep what differs within any of them.
void keep_what_varies(std::array<NumberedNames, 3>& lists) {
  std::array<std::vector<bool>, 3> kept;
  for (std::size_t l = 0; l < lists.size(); ++l) {
    kept[l].resize(lists[l].count());
    for (std::size_t i = 0; i < kept[l].size(); ++i) kept[l][i] = lists[l].varies(i);
  }
  const std::array<std::vector<bool>, 3> own = kept;
  for (std::size_t l = 0; l < lists.size(); ++l) {
    for (const std::vector<bool>& other : own) {
      if (other.size() != kept[l].size()) continue;
      for (std::size_t i = 0; i < other.size(); ++i) kept[l][i] = kept[l][i] || other[i];
    }
    if (!kept[l].empty() && std::count(kept[l].begin(), kept[l].end(), true) == 0) kept[l].back() = true;  // one file
    for (std::vector<std::string>& numbers : lists[l].numbers) {
      std::vector<std::string> varying;
      for (std::size_t i = 0; i < numbers.size(); ++i) {
        if (kept[l][i]) varying.push_back(numbers[i]);
      }
      numbers = std::move(varying);
    }
  }
}

// Path by place in the sequence.
using Places = std::map<std::vector<std::string>, std::string>;

Places places_of(const fs::path& root, const NumberedNames& names) {
  Places places;
  for (std::size_t i = 0; i < names.paths.size(); ++i) {
    const auto [at, added] = places.emplace(names.numbers[i], names.paths[i]);
    if (added) continue;
    if (stem_of(at->second) == stem_of(names.paths[i])) {  // 1.jpg beside 1.png: the same choice on every file system
      at->second = std::min(at->second, names.paths[i]);
      continue;
    }
    throw Error(fmt::format("{}: {} and {} have the same number; rename one", root.string(), at->second, names.paths[i]));
  }
  return places;
}

// A place as one number, in nanoseconds if it is a time stamp; nothing if it has several numbers or too many digits.
std::optional<std::int64_t> to_frame_number(const std::vector<std::string>& place) {
  if (place.size() != 1) return std::nullopt;
  std::string digits = place.front();
  const std::size_t point = digits.find('.');
  if (point != std::string::npos) digits = digits.substr(0, point) + digits.substr(point + 1, kNanoDigits);
  digits.erase(0, std::min(digits.find_first_not_of('0'), digits.size() - 1));
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  return error == std::errc{} && end == digits.data() + digits.size() ? std::optional(value) : std::nullopt;
}

std::size_t count_common(const Places& a, const Places& b) {
  return static_cast<std::size_t>(std::count_if(a.begin(), a.end(), [&](const auto& item) { return b.contains(item.first); }));
}

// True if the numbers of equally many images differ by the same amount throughout: the two lists were counted from another start.
bool shifted(const Places& color, const Places& depth) {
  if (color.size() != depth.size() || color.size() < 2) return false;
  std::optional<std::int64_t> shift;
  for (auto c = color.begin(), d = depth.begin(); c != color.end(); ++c, ++d) {
    const auto a = to_frame_number(c->first);
    const auto b = to_frame_number(d->first);
    if (!a || !b || (shift && *b - *a != *shift)) return false;
    shift = *b - *a;
  }
  return *shift != 0;
}

// Gives the depth images the places of the colour images, one after the other.
Places in_order_of(const Places& depth, const Places& color) {
  Places result;
  auto d = depth.begin();
  for (const auto& [place, path] : color) result[place] = (d++)->second;
  return result;
}

void match(FileRecording& recording, const Places& color, Places& depth) {
  if (color.empty() || depth.empty()) return;
  const std::size_t common = count_common(color, depth);
  if (!shifted(color, depth) && common > 0) return;
  const std::string& first_color = color.begin()->second;
  const std::string& first_depth = depth.begin()->second;
  if (color.size() != depth.size()) {
    throw Error(
        fmt::format("{}: {} colour and {} depth images, of which no two have the same number (the first are {} and {}); "
                    "give the images of a pair the same number",
                    recording.root.string(), color.size(), depth.size(), first_color, first_depth));
  }
  recording.assumed.push_back(
      fmt::format("the numbers of colour and depth images differ ({} and {} are the first): they are paired "
                  "in their order",
                  first_color, first_depth));
  depth = in_order_of(depth, color);
}

bool are_times(const Places& places) {
  return !places.empty() && places.begin()->first.size() == 1 && places.begin()->first.front().find('.') != std::string::npos;
}

std::vector<FileFrame> to_frames(const Places& color, const Places& depth, const Places& poses) {
  constexpr double kAssumedRate_hz = 30;
  constexpr double kNanoseconds = 1e-9;
  std::map<std::vector<std::string>, FileFrame> frames;
  for (const auto& [place, path] : color) frames[place].color = path;
  for (const auto& [place, path] : depth) frames[place].depth = path;
  const bool numbered =
      std::all_of(frames.begin(), frames.end(), [](const auto& item) { return to_frame_number(item.first).has_value(); });
  const double unit_s = are_times(color) ? kNanoseconds : 1 / kAssumedRate_hz;
  std::vector<FileFrame> result;
  result.reserve(frames.size());
  for (auto& [place, frame] : frames) {
    frame.number = numbered ? *to_frame_number(place) : static_cast<std::int64_t>(result.size());
    frame.time_s = static_cast<double>(frame.number) * (numbered ? unit_s : 1 / kAssumedRate_hz);
    const auto pose = poses.find(place);
    if (pose != poses.end()) frame.pose_file = pose->second;
    result.push_back(std::move(frame));
  }
  return result;
}

}  // namespace

std::string ending_of(const fs::path& path) { return lower_case(path.extension().string()); }

std::vector<std::string> files_in(const fs::path& root, const std::string& folder, std::span<const std::string_view> endings) {
  std::vector<std::string> files;
  for (const fs::path name : names_in_folder(root / folder)) {
    const bool is_hidden = name.native().starts_with('.');
    const bool fits = std::find(endings.begin(), endings.end(), ending_of(name)) != endings.end();
    if (fits && !is_hidden) files.push_back((fs::path(folder) / name).string());
  }
  return files;
}

void require_color_images(const fs::path& root, const std::string& folder, const std::vector<std::string>& files) {
  if (!files.empty()) return;
  const std::vector<std::string> names = names_in_folder(root / folder);
  const auto visible = std::find_if(names.begin(), names.end(), [](const std::string& name) { return !name.starts_with('.'); });
  throw Error(fmt::format("{}: no colour image ({}); {}", (root / folder).string(), fmt::join(kColorEndings, ", "),
                          visible == names.end()
                              ? "the folder is empty"
                              : fmt::format("it has {} files, {} for one: convert them", names.size(), *visible)));
}

void add_frames_by_name(FileRecording& recording, const RecordingFiles& files) {
  std::array<NumberedNames, 3> lists = {with_numbers(files.color), with_numbers(files.depth), with_numbers(files.poses)};
  for (std::size_t l = 0; l < lists.size(); ++l) {
    if (!lists[l].uniform()) lists[l] = of_one_form(lists[l], lists[l == 0 ? 1 : 0]);
  }
  keep_what_varies(lists);
  const Places color = places_of(recording.root, lists[0]);
  Places depth = places_of(recording.root, lists[1]);
  match(recording, color, depth);
  recording.frames = to_frames(color, depth, places_of(recording.root, lists[2]));
}

}  // namespace panoptic
