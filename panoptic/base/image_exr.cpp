// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// OpenEXR by its core library alone, which needs nothing but zlib.
#include <fmt/format.h>
#include <openexr.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "panoptic/base/image_codecs.h"

namespace panoptic {
namespace {

std::int64_t take_exr_bytes(exr_const_context_t /*context*/, void* user, void* to, std::uint64_t count, std::uint64_t offset,
                            exr_stream_error_func_ptr_t /*complain*/) {
  const EncodedImage& file = *static_cast<const EncodedImage*>(user);
  const std::uint64_t left = file.bytes.size() - std::min<std::uint64_t>(offset, file.bytes.size());
  const std::uint64_t taken = std::min(count, left);  // the header is asked for in blocks that may end behind the file
  if (taken > 0) std::memcpy(to, file.bytes.data() + offset, taken);
  return static_cast<std::int64_t>(taken);
}

std::int64_t exr_size(exr_const_context_t /*context*/, void* user) {
  return static_cast<std::int64_t>(static_cast<const EncodedImage*>(user)->bytes.size());
}

void ignore_exr_error(exr_const_context_t /*context*/, exr_result_t /*code*/, const char* /*message*/) {}

class ExrReader {
 public:
  explicit ExrReader(const EncodedImage& file) : file_(file) {
    constexpr int kMostSide_px = 65536;
    exr_context_initializer_t start = EXR_DEFAULT_CONTEXT_INITIALIZER;
    start.error_handler_fn = ignore_exr_error;
    start.user_data = &file_;
    start.read_fn = take_exr_bytes;
    start.size_fn = exr_size;
    start.max_image_width = kMostSide_px;
    start.max_image_height = kMostSide_px;
    start.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    require(exr_start_read(&context_, "depth.exr", &start));
  }
  ~ExrReader() {
    exr_decoding_destroy(context_, &pipeline_);
    exr_finish(&context_);
  }
  ExrReader(const ExrReader&) = delete;
  ExrReader& operator=(const ExrReader&) = delete;

  Image<float> depth() {
    exr_storage_t storage = EXR_STORAGE_LAST_TYPE;
    require(exr_get_storage(context_, 0, &storage));
    if (storage != EXR_STORAGE_SCANLINE) refuse_depth(file_, "an OpenEXR file that is not in scan lines");
    exr_attr_box2i_t window{};
    require(exr_get_data_window(context_, 0, &window));
    const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
    const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
    constexpr std::int64_t kMostPixelsPerByte = 2048;  // more than any depth image is packed
    if (width <= 0 || height <= 0 || width * height > static_cast<std::int64_t>(file_.bytes.size()) * kMostPixelsPerByte)
      refuse_damaged(file_, "its size is out of range");
    auto image = image_for<float>(file_, static_cast<std::uint64_t>(width), static_cast<std::uint64_t>(height));
    const std::string channel = depth_channel();
    std::int32_t step = 1;
    require(exr_get_scanlines_per_chunk(context_, 0, &step));
    if (step < 1) refuse_damaged(file_, "its chunks have no lines");
    for (std::int64_t v = 0; v < height; v += step) read_lines(static_cast<int>(v), window.min.y, channel, image);
    return image;
  }

 private:
  void require(exr_result_t result) const {
    if (result != EXR_ERR_SUCCESS) refuse_damaged(file_, exr_get_default_error_message(result));
  }

  std::string depth_channel() const {
    const exr_attr_chlist_t* channels = nullptr;
    require(exr_get_channels(context_, 0, &channels));
    for (const char* wanted : {"Z", "depth", "Depth", "depth.Z", "Depth.Z", "Depth.V", "V", "Y", "R"}) {
      for (int i = 0; i < channels->num_channels; ++i) {
        const exr_attr_chlist_entry_t& channel = channels->entries[i];
        if (channel.x_sampling != 1 || channel.y_sampling != 1) refuse_depth(file_, "an OpenEXR file with coarser channels");
        if (std::string_view(channel.name.str) == wanted) return wanted;
      }
    }
    if (channels->num_channels == 1) return channels->entries[0].name.str;
    refuse_depth(file_, fmt::format("an OpenEXR file with {} channels and no Z among them", channels->num_channels));
  }

  // The lines of one chunk, from row v of the image on.
  void read_lines(int v, int first_y, const std::string& channel, Image<float>& image) {
    exr_chunk_info_t chunk{};
    require(exr_read_scanline_chunk_info(context_, 0, first_y + v, &chunk));
    const bool starts = pipeline_.context == nullptr;
    require(starts ? exr_decoding_initialize(context_, 0, &chunk, &pipeline_)
                   : exr_decoding_update(context_, 0, &chunk, &pipeline_));
    for (int i = 0; i < pipeline_.channel_count; ++i) {
      exr_coding_channel_info_t& info = pipeline_.channels[i];
      info.decode_to_ptr = nullptr;
      if (info.channel_name != channel) continue;
      if (info.width != image.width() || info.height > image.height() - v) refuse_damaged(file_, "its lines do not fit");
      info.user_bytes_per_element = sizeof(float);
      info.user_data_type = EXR_PIXEL_FLOAT;
      info.user_pixel_stride = sizeof(float);
      info.user_line_stride = static_cast<std::int32_t>(sizeof(float)) * image.width();
      info.decode_to_ptr = reinterpret_cast<std::uint8_t*>(image.row(v));
    }
    if (starts) require(exr_decoding_choose_default_routines(context_, 0, &pipeline_));
    require(exr_decoding_run(context_, 0, &pipeline_));
  }

  EncodedImage file_;
  exr_context_t context_ = nullptr;
  exr_decode_pipeline_t pipeline_ = EXR_DECODE_PIPELINE_INITIALIZER;
};

}  // namespace

DepthImage decode_exr(const EncodedImage& file) { return ExrReader(file).depth(); }

}  // namespace panoptic
