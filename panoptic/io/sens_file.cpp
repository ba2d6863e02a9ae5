// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/sens_file.h"

#include <fmt/format.h>

#include <bit>
#include <cerrno>
#include <cmath>
#include <type_traits>
#include <utility>

#include "panoptic/base/files.h"
#include "panoptic/error.h"

namespace panoptic {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are stored");

namespace {

constexpr std::uint32_t kVersion = 4;
constexpr std::uint64_t kMaxNameBytes = 4096;
constexpr std::uint32_t kMaxSide_px = 16384;
constexpr std::uint64_t kMaxPixels = std::uint64_t{32} << 20;

// Reads one value after the other; the first that is missing ends in an Error.
class Cursor {
 public:
  Cursor(const SensFile& file, std::uint64_t offset) : file_(file), offset_(offset) {}

  template <typename T>
  void take(T& value, const char* what) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (!file_.read(offset_, &value, sizeof(T))) {
      throw Error(fmt::format("{}: cut off at byte {}, in {}; copy the file again", file_.name(), file_.size(), what));
    }
    offset_ += sizeof(T);
  }
  void skip(std::uint64_t bytes, const char* what) {
    if (bytes > file_.size() - offset_) {
      throw Error(fmt::format("{}: cut off at byte {}, in {}; copy the file again", file_.name(), file_.size(), what));
    }
    offset_ += bytes;
  }
  std::uint64_t offset() const { return offset_; }
  std::uint64_t bytes_left() const { return file_.size() - offset_; }

 private:
  const SensFile& file_;
  std::uint64_t offset_;
};

void take_start(Cursor& cursor, const std::string& name) {
  std::uint32_t version = 0;
  std::uint64_t name_bytes = 0;
  cursor.take(version, "the version");
  if (version != kVersion) {
    throw Error(fmt::format("{}: .sens version {}, only version 4 can be read; is it a .sens file?", name, version));
  }
  cursor.take(name_bytes, "the length of the sensor's name");
  if (name_bytes > kMaxNameBytes) {
    throw Error(
        fmt::format("{}: the sensor's name claims {} bytes, more than {}; the file is damaged", name, name_bytes, kMaxNameBytes));
  }
  cursor.skip(name_bytes, "the sensor's name");
}

StreamHeader take_header(Cursor& cursor) {
  StreamHeader h;
  cursor.take(h.color_intrinsic, "the colour intrinsics");
  cursor.take(h.color_extrinsic, "the colour extrinsics");
  cursor.take(h.depth_intrinsic, "the depth intrinsics");
  cursor.take(h.depth_extrinsic, "the depth extrinsics");
  cursor.take(h.color_compression, "the colour compression");
  cursor.take(h.depth_compression, "the depth compression");
  cursor.take(h.color_width, "the image sizes");
  cursor.take(h.color_height, "the image sizes");
  cursor.take(h.depth_width, "the image sizes");
  cursor.take(h.depth_height, "the image sizes");
  cursor.take(h.depth_shift, "the depth shift");
  cursor.take(h.frame_count, "the number of frames");
  return h;
}

bool sane_size(std::uint32_t width, std::uint32_t height) {
  return width > 0 && height > 0 && width <= kMaxSide_px && height <= kMaxSide_px && std::uint64_t{width} * height <= kMaxPixels;
}

void check(const StreamHeader& h, const std::string& name) {
  const auto color = static_cast<std::int32_t>(h.color_compression);
  const auto depth = static_cast<std::int32_t>(h.depth_compression);
  if (color < 0 || color > 2)
    throw Error(fmt::format("{}: colour compression {} cannot be read (0 raw, 1 PNG, 2 JPEG can)", name, color));
  if (depth < 0 || depth > 1)
    throw Error(fmt::format("{}: depth compression {} cannot be read (0 raw, 1 zlib can)", name, depth));
  if (!sane_size(h.color_width, h.color_height) || !sane_size(h.depth_width, h.depth_height)) {
    throw Error(fmt::format("{}: image sizes {}x{} (colour) and {}x{} (depth) are not plausible; the file is damaged", name,
                            h.color_width, h.color_height, h.depth_width, h.depth_height));
  }
  if (!std::isfinite(h.depth_shift) || h.depth_shift <= 0) {
    throw Error(fmt::format("{}: depth shift {} is not a positive number; the file is damaged", name, h.depth_shift));
  }
}

// Finds where every frame begins. The count is checked against the file's size before memory is taken.
std::vector<std::uint64_t> index_frames(const SensFile& file, Cursor& cursor, std::uint64_t count) {
  if (count > cursor.bytes_left() / sizeof(FrameHeader)) {
    throw Error(fmt::format("{}: claims {} frames, more than its {} bytes can hold; the file is cut off or damaged", file.name(),
                            count, file.size()));
  }
  std::vector<std::uint64_t> offsets;
  offsets.reserve(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    offsets.push_back(cursor.offset());
    FrameHeader frame;
    const std::string what = fmt::format("frame {} of {}", i, count);
    cursor.take(frame, what.c_str());
    if (frame.color_bytes > kMaxSensBlobBytes || frame.depth_bytes > kMaxSensBlobBytes) {
      throw Error(fmt::format("{}: {} claims images of {} and {} bytes; the file is damaged", file.name(), what,
                              frame.color_bytes, frame.depth_bytes));
    }
    cursor.skip(frame.color_bytes + frame.depth_bytes, what.c_str());
  }
  return offsets;  // the sensor's acceleration records, which follow, are not needed
}

}  // namespace

SensFile::SensFile(const std::filesystem::path& path) : name_(path.string()), file_(os::open_to_read(path)) {
  const auto status = file_.status();
  if (!status) {
    throw FileError(fmt::format("cannot read {}: {}; check the path and its permissions", name_, os::reason(errno)));
  }
  size_ = status->size;
}

bool SensFile::read(std::uint64_t offset, void* to, std::uint64_t bytes) const {
  if (offset > size_ || bytes > size_ - offset) return false;
  const auto got = file_.read(offset, to, bytes);
  if (!got) throw FileError(fmt::format("cannot read {}: {}; check the disk", name_, os::reason(errno)));
  return *got == bytes;
}

std::optional<std::vector<std::uint8_t>> SensFile::read(std::uint64_t offset, std::uint64_t bytes) const {
  if (offset > size_ || bytes > size_ - offset) return std::nullopt;
  std::vector<std::uint8_t> blob(bytes);
  return read(offset, blob.data(), bytes) ? std::optional(std::move(blob)) : std::nullopt;
}

SensIndex read_sens_index(const SensFile& file) {
  Cursor cursor(file, 0);
  take_start(cursor, file.name());
  const StreamHeader header = take_header(cursor);
  check(header, file.name());
  return {header, index_frames(file, cursor, header.frame_count)};
}

}  // namespace panoptic
