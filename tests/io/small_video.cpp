// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/io/small_video.h"

#ifdef PANOPTIC_VIDEO

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include <cstring>

#include "panoptic/error.h"

namespace panoptic::test {
namespace {

void require(bool holds, const char* what) {
  if (!holds) throw Error(std::string("cannot write a video for a test: ") + what);
}

void fill(AVFrame& frame, const Image<Rgb>& image) {
  if (frame.format == AV_PIX_FMT_RGB24) {
    for (int v = 0; v < image.height(); ++v)
      std::memcpy(frame.data[0] + v * frame.linesize[0], image.row(v), static_cast<std::size_t>(image.width()) * sizeof(Rgb));
    return;
  }
  constexpr int kBlack = 16;  // of television, where white is 235
  constexpr int kRange = 219;
  constexpr int kNoColor = 128;
  for (int v = 0; v < image.height(); ++v) {
    for (int u = 0; u < image.width(); ++u)
      frame.data[0][v * frame.linesize[0] + u] = static_cast<std::uint8_t>(kBlack + image(u, v).g * kRange / 255);
  }
  for (int v = 0; v < image.height() / 2; ++v) {
    for (const int plane : {1, 2})
      std::memset(frame.data[plane] + v * frame.linesize[plane], kNoColor, static_cast<std::size_t>(image.width()) / 2);
  }
}

// One that is written: gives the encoder an image, or its end, and stores what comes out.
struct Writer {
  AVFormatContext* format = nullptr;
  AVCodecContext* codec = nullptr;
  AVPacket* packet = av_packet_alloc();

  void encode(const AVFrame* frame) {
    require(avcodec_send_frame(codec, frame) >= 0, "the encoder");
    while (avcodec_receive_packet(codec, packet) >= 0) {
      av_packet_rescale_ts(packet, codec->time_base, format->streams[0]->time_base);
      require(av_interleaved_write_frame(format, packet) >= 0, "the file");
    }
  }
  ~Writer() {
    av_packet_free(&packet);
    avcodec_free_context(&codec);
    if (format != nullptr) avio_closep(&format->pb);
    avformat_free_context(format);
  }
};

void open(Writer& writer, const std::filesystem::path& path, const Image<Rgb>& first, const VideoKind& kind) {
  const AVCodec* encoder = avcodec_find_encoder_by_name(kind.codec.c_str());
  require(avformat_alloc_output_context2(&writer.format, nullptr, "mp4", path.c_str()) >= 0, "the format");
  writer.codec = avcodec_alloc_context3(encoder);
  AVCodecContext& codec = *writer.codec;
  const bool is_lossless = kind.codec == "libx264rgb";
  codec.width = first.width();
  codec.height = first.height();
  codec.pix_fmt = is_lossless ? AV_PIX_FMT_RGB24 : AV_PIX_FMT_YUV420P;
  codec.time_base = {1, 600};
  codec.framerate = {60, 1};
  codec.gop_size = kind.key_every;
  codec.max_b_frames = kind.images_between;
  codec.flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  codec.thread_count = 1;
  codec.bit_rate = 4'000'000;
  AVDictionary* options = nullptr;
  if (is_lossless) av_dict_set(&options, "qp", "0", 0);
  if (is_lossless) av_dict_set(&options, "preset", "ultrafast", 0);
  if (is_lossless) av_dict_set(&options, "x264-params", "b-adapt=0", 0);
  if (kind.codec == "libx265")
    av_dict_set(&options, "x265-params", "log-level=none:ctu=16:cutree=0:lossless=1:pools=none:frame-threads=1", 0);
  require(avcodec_open2(&codec, encoder, &options) >= 0, "opening the encoder");
  av_dict_free(&options);
  AVStream* stream = avformat_new_stream(writer.format, nullptr);
  stream->time_base = codec.time_base;
  require(avcodec_parameters_from_context(stream->codecpar, &codec) >= 0, "the parameters");
  require(avio_open(&writer.format->pb, path.c_str(), AVIO_FLAG_WRITE) >= 0, "opening the file");
  if (kind.index_first) av_dict_set(&options, "movflags", "faststart", 0);
  require(avformat_write_header(writer.format, &options) >= 0, "the header");
  av_dict_free(&options);
}

}  // namespace

bool write_video(const std::filesystem::path& path, const std::vector<Image<Rgb>>& images, const VideoKind& kind) {
  av_log_set_level(AV_LOG_QUIET);
  if (avcodec_find_encoder_by_name(kind.codec.c_str()) == nullptr) return false;
  std::filesystem::create_directories(path.parent_path());
  Writer writer;
  open(writer, path, images.front(), kind);
  AVFrame* frame = av_frame_alloc();
  for (std::size_t i = 0; i < images.size(); ++i) {
    av_frame_unref(frame);
    frame->format = writer.codec->pix_fmt;
    frame->width = images[i].width();
    frame->height = images[i].height();
    require(av_frame_get_buffer(frame, 0) >= 0, "memory");
    fill(*frame, images[i]);
    frame->pts = static_cast<std::int64_t>(10 * i + i % 3);
    writer.encode(frame);
  }
  writer.encode(nullptr);
  av_frame_free(&frame);
  require(av_write_trailer(writer.format) >= 0, "the end");
  return true;
}

}  // namespace panoptic::test

#else

namespace panoptic::test {

bool write_video(const std::filesystem::path&, const std::vector<Image<Rgb>>&, const VideoKind&) { return false; }

}  // namespace panoptic::test

#endif
