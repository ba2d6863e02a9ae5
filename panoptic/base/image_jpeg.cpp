// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include <turbojpeg.h>

#include <memory>
#include <new>
#include <type_traits>

#include "panoptic/base/image_codecs.h"

namespace panoptic {
namespace {

struct CloseTurboJpeg {
  void operator()(tjhandle handle) const { tjDestroy(handle); }
};
using TurboJpeg = std::unique_ptr<std::remove_pointer_t<tjhandle>, CloseTurboJpeg>;

TurboJpeg opened(tjhandle handle) {
  if (handle == nullptr) throw std::bad_alloc();
  return TurboJpeg(handle);
}

struct JpegHeader {
  int width = 0;
  int height = 0;
  int colors = -1;  // one of TJCS
};

JpegHeader read_jpeg_header(tjhandle jpeg, const EncodedImage& file) {
  JpegHeader header;
  int sampling = -1;
  const int result =
      tjDecompressHeader3(jpeg, file.bytes.data(), file.bytes.size(), &header.width, &header.height, &sampling, &header.colors);
  // A sampling that TurboJPEG has no name for is reported as an error too, after the rest is filled in; it is decoded like
  // others.
  const bool is_known = header.width > 0 && header.height > 0 && header.colors >= 0;
  if (!is_known || (result != 0 && sampling >= 0)) refuse_damaged(file, tjGetErrorStr2(jpeg));
  if (header.colors == TJCS_CMYK || header.colors == TJCS_YCCK) refuse_kind(file, "its colours are CMYK");
  return header;
}

// The accurate transforms of libjpeg, chroma interpolated. What is damaged ends it at once.
template <typename T>
Image<T> read_jpeg_pixels(tjhandle jpeg, const EncodedImage& file, const JpegHeader& header, int format) {
  constexpr int kFlags = TJFLAG_ACCURATEDCT | TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS;
  auto image = image_for<T>(file, static_cast<std::uint64_t>(header.width), static_cast<std::uint64_t>(header.height));
  if (tjDecompress2(jpeg, file.bytes.data(), file.bytes.size(), reinterpret_cast<std::uint8_t*>(image.data()), image.width(), 0,
                    image.height(), format, kFlags) != 0) {
    refuse_damaged(file, tjGetErrorStr2(jpeg));
  }
  return image;
}

}  // namespace

Image<Rgb> decode_jpeg_rgb(const EncodedImage& file) {
  const TurboJpeg jpeg = opened(tjInitDecompress());
  return read_jpeg_pixels<Rgb>(jpeg.get(), file, read_jpeg_header(jpeg.get(), file), TJPF_RGB);
}

Image<std::uint16_t> decode_jpeg_gray16(const EncodedImage& file) {
  const TurboJpeg jpeg = opened(tjInitDecompress());
  const JpegHeader header = read_jpeg_header(jpeg.get(), file);
  if (header.colors != TJCS_GRAY) refuse_channels(file, 3, 8);
  return widened(read_jpeg_pixels<std::uint8_t>(jpeg.get(), file, header, TJPF_GRAY));
}

std::vector<std::uint8_t> jpeg_from_rows(const PixelRows& rgb, int quality) {
  const TurboJpeg jpeg = opened(tjInitCompress());
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  const int result = tjCompress2(jpeg.get(), static_cast<const unsigned char*>(rgb.data), rgb.width, 0, rgb.height, TJPF_RGB,
                                 &bytes, &size, TJSAMP_420, quality, TJFLAG_ACCURATEDCT);
  const std::unique_ptr<unsigned char, decltype(&tjFree)> owner(bytes, tjFree);
  if (result != 0) return {};
  return {bytes, bytes + size};
}

}  // namespace panoptic
