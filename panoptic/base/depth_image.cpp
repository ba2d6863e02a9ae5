// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/base/depth_image.h"

#include <fmt/format.h>

#include "panoptic/base/files.h"
#include "panoptic/base/image_codecs.h"
#include "panoptic/base/image_header.h"
#include "panoptic/base/image_io.h"
#include "panoptic/error.h"

namespace panoptic {
void refuse_depth(const EncodedImage& file, std::string_view kind) {
  throw Error(fmt::format("{}: {}; depth needs one channel of 16 bits or floats", file.name, kind));
}

DepthImage decode_depth_image(std::span<const std::uint8_t> bytes, std::string_view name) {
  const EncodedImage file{bytes, name};
  switch (image_format(bytes)) {
    case ImageFormat::kNpy:
      return decode_npy(file);
    case ImageFormat::kExr:
      return decode_exr(file);
    case ImageFormat::kJpeg:
      refuse_depth(file, "a JPEG, of 8 bits and blurred");
    default:
      break;
  }
  if (!is_acceptable_image(bytes, kMaxImagePixels)) return decode_gray16(bytes, name);  // which says why not
  if (image_format(bytes) == ImageFormat::kTiff) return decode_tiff_depth(file);
  const SampleKind kind = sample_kind(bytes);
  if (kind.channels != 1 || kind.bits != 16) {
    refuse_depth(file, kind.channels == 1 ? fmt::format("grey of {} bits", kind.bits) : std::string("a colour picture"));
  }
  return decode_gray16(bytes, name);
}

DepthImage read_depth_image(const std::filesystem::path& path) {
  const std::string bytes = read_file(path, kMaxImageFileBytes);
  return decode_depth_image({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, path.string());
}

}  // namespace panoptic
