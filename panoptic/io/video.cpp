// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
#include "panoptic/io/video.h"

#include <fmt/format.h>

#include "panoptic/error.h"

#ifdef PANOPTIC_VIDEO

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libswscale/swscale.h>
}

#include <algorithm>
#include <array>
#include <cstdint>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "panoptic/base/files.h"
#include "panoptic/base/image_codecs.h"

namespace panoptic {
namespace {

struct Closer {
  void operator()(AVFormatContext* p) const { avformat_close_input(&p); }
  void operator()(AVCodecContext* p) const { avcodec_free_context(&p); }
  void operator()(AVPacket* p) const { av_packet_free(&p); }
  void operator()(AVFrame* p) const { av_frame_free(&p); }
  void operator()(SwsContext* p) const { sws_freeContext(p); }
};
template <typename T>
using Owned = std::unique_ptr<T, Closer>;

// More than an image of kMaxImagePixels in ten bits takes, for the decoder and for the process' other users of these libraries.
constexpr std::size_t kMostBlockBytes = std::size_t{400} << 20;

std::string words_of(int error) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
  av_strerror(error, text.data(), text.size());
  return text.data();
}

struct StoredImage {
  std::int64_t shown = 0;   // the time stamp by which images are put in order
  std::int64_t stored = 0;  // ... and the one by which the file is searched
  bool is_key = false;      // can be decoded without others
};

Owned<AVFormatContext> open_file(const std::filesystem::path& path) {
  if (!is_file(path)) throw Error(fmt::format("{}: no such file", path.string()));
  av_log_set_level(AV_LOG_QUIET);  // what is wrong is said by exceptions
  av_max_alloc(kMostBlockBytes);   // headers may ask for any number of entries
  AVDictionary* options = nullptr;
  av_dict_set(&options, "protocol_whitelist", "file", 0);  // a file may name others, elsewhere
  av_dict_set(&options, "ignore_editlist", "1", 0);        // every image that was stored, also those that are not to be shown
  AVFormatContext* format = nullptr;
  const int opened = avformat_open_input(&format, ("file:" + path.string()).c_str(), av_find_input_format("mov"), &options);
  av_dict_free(&options);
  if (opened < 0) {
    throw Error(fmt::format("{}: no video that can be read ({}); was it copied whole?", path.string(), words_of(opened)));
  }
  return Owned<AVFormatContext>(format);
}

Owned<AVCodecContext> open_codec(const AVStream& stream, const AVCodec* codec, const std::string& name) {
  const AVCodecParameters& p = *stream.codecpar;
  if (codec == nullptr || (p.codec_id != AV_CODEC_ID_H264 && p.codec_id != AV_CODEC_ID_HEVC))
    throw Error(fmt::format("{}: neither H.264 nor HEVC, as phones film in: extract its images (ffmpeg)", name));
  if (p.width <= 0 || p.height <= 0 || std::int64_t{p.width} * p.height > std::int64_t{kMaxImagePixels})
    throw Error(fmt::format("{}: images of {}x{} pixels are not read", name, p.width, p.height));
  Owned<AVCodecContext> context(avcodec_alloc_context3(codec));
  if (context == nullptr || avcodec_parameters_to_context(context.get(), &p) < 0) throw std::bad_alloc();
  context->pkt_timebase = stream.time_base;
  context->thread_count = 1;  // the same images every time
  context->max_pixels = std::int64_t{kMaxImagePixels};
  context->err_recognition = AV_EF_EXPLODE | AV_EF_BITSTREAM | AV_EF_BUFFER | AV_EF_CRCCHECK;
  if (const int opened = avcodec_open2(context.get(), codec, nullptr); opened < 0)
    throw Error(fmt::format("{}: its images cannot be decoded ({})", name, words_of(opened)));
  return context;
}

bool is_key(const AVFrame& frame) {
#if LIBAVUTIL_VERSION_INT >= AV_VERSION_INT(58, 29, 100)
  return (frame.flags & AV_FRAME_FLAG_KEY) != 0;
#else
  return frame.key_frame != 0;
#endif
}

bool is_damaged(const AVFrame& frame) { return (frame.flags & AV_FRAME_FLAG_CORRUPT) != 0 || frame.decode_error_flags != 0; }

// The matrix of the colours; a file that does not name it has that of television: the newer one from 720 rows on.
int color_space(const AVFrame& frame) {
  constexpr int kHighDefinition = 720;
  if (frame.colorspace != AVCOL_SPC_UNSPECIFIED && frame.colorspace != AVCOL_SPC_RGB) return frame.colorspace;
  return frame.height >= kHighDefinition ? SWS_CS_ITU709 : SWS_CS_ITU601;
}

}  // namespace

struct Video::Decoder {
  std::string name;
  Owned<AVFormatContext> format;
  Owned<AVCodecContext> codec;
  Owned<AVPacket> packet{av_packet_alloc()};
  Owned<AVFrame> frame{av_frame_alloc()};  // the last that came out of the decoder
  Owned<SwsContext> converter;
  int stream = -1;
  std::vector<StoredImage> images;  // as they are shown
  bool is_cut_off = false;
  std::optional<std::size_t> last;  // the position of `frame`; nothing: none came out since the search
  bool damaged = false;             // `frame`, or one since the last key image
  std::mutex mutex;

  explicit Decoder(const std::filesystem::path& path) : name(path.string()), format(open_file(path)) {
    const AVCodec* found = nullptr;
    stream = av_find_best_stream(format.get(), AVMEDIA_TYPE_VIDEO, -1, -1, &found, 0);
    if (stream < 0) throw Error(fmt::format("{}: a file without a video that can be decoded", name));
    for (unsigned i = 0; i < format->nb_streams; ++i) {
      if (static_cast<int>(i) != stream) format->streams[i]->discard = AVDISCARD_ALL;
    }
    codec = open_codec(*format->streams[stream], found, name);
    list_images();
  }

  // Every image by its place, told by the time stamps.
  void list_images() {
    int status = 0;
    while ((status = av_read_frame(format.get(), packet.get())) >= 0) {
      const AVPacket& p = *packet;
      const bool is_broken = (p.flags & AV_PKT_FLAG_CORRUPT) != 0;
      if (p.stream_index == stream && p.pts == AV_NOPTS_VALUE)
        throw Error(fmt::format("{}: its images have no time stamps, so that they cannot be told apart", name));
      if (p.stream_index == stream && !is_broken && (p.flags & AV_PKT_FLAG_DISCARD) == 0)
        images.push_back({p.pts, p.dts == AV_NOPTS_VALUE ? p.pts : p.dts, (p.flags & AV_PKT_FLAG_KEY) != 0});
      av_packet_unref(packet.get());
      is_cut_off = is_cut_off || is_broken;
      if (is_broken) break;
    }
    is_cut_off = is_cut_off || (status < 0 && status != AVERROR_EOF);
    std::stable_sort(images.begin(), images.end(), [](const auto& a, const auto& b) { return a.shown < b.shown; });
    const auto same = [](const auto& a, const auto& b) { return a.shown == b.shown; };
    if (std::adjacent_find(images.begin(), images.end(), same) != images.end())
      throw Error(fmt::format("{}: two of its images have the same time stamp, so that they cannot be told apart", name));
    if (images.empty() || !images.front().is_key)
      throw Error(
          fmt::format("{}: {}; was it copied whole?", name, images.empty() ? "no image in it" : "its first image is missing"));
  }

  [[noreturn]] void refuse(std::size_t position) const {
    throw Error(fmt::format("{}: image {} of {} is damaged, or one that it is derived from; was it copied whole?", name, position,
                            images.size()));
  }

  void go_to(std::size_t position) {
    const auto first_after = images.begin() + static_cast<std::ptrdiff_t>(position) + 1;
    const auto key = std::find_if(std::make_reverse_iterator(first_after), images.rend(), [](const auto& i) { return i.is_key; });
    const auto key_position = static_cast<std::size_t>(images.rend() - key) - 1;
    const bool is_ahead = last && *last <= position;
    if (is_ahead && key_position <= *last + 1) return;
    last.reset();
    damaged = false;
    avcodec_flush_buffers(codec.get());
    if (av_seek_frame(format.get(), stream, key->stored, AVSEEK_FLAG_BACKWARD) < 0) refuse(position);
  }

  // Gives the decoder the next packet, or says that there are no more.
  void feed() {
    int status = av_read_frame(format.get(), packet.get());
    while (status >= 0 && packet->stream_index != stream) {
      av_packet_unref(packet.get());
      status = av_read_frame(format.get(), packet.get());
    }
    const int sent = avcodec_send_packet(codec.get(), status >= 0 ? packet.get() : nullptr);
    if (status >= 0) av_packet_unref(packet.get());
    if (sent < 0 && sent != AVERROR_EOF) damaged = true;
  }

  // The next image, in the order in which they are shown; false at the end.
  bool next() {
    while (true) {
      const int status = avcodec_receive_frame(codec.get(), frame.get());
      if (status == AVERROR_EOF) return false;
      if (status == AVERROR(EAGAIN)) {
        feed();
        continue;
      }
      if (status < 0) {
        damaged = true;
        continue;
      }
      damaged = is_damaged(*frame) || (damaged && !is_key(*frame));
      const auto at = std::lower_bound(images.begin(), images.end(), frame->pts,
                                       [](const StoredImage& image, std::int64_t pts) { return image.shown < pts; });
      if (at == images.end() || at->shown != frame->pts) continue;  // one that is not to be shown
      last = static_cast<std::size_t>(at - images.begin());
      return true;
    }
  }

  Image<Rgb> converted() {
    constexpr int kPixelBytes = 3;
    constexpr int kAlignment = 64;
    const int width = frame->width;
    const int height = frame->height;
    constexpr int kFlags = SWS_BILINEAR | SWS_ACCURATE_RND | SWS_BITEXACT | SWS_FULL_CHR_H_INT;
    converter.reset(sws_getCachedContext(converter.release(), width, height, static_cast<AVPixelFormat>(frame->format), width,
                                         height, AV_PIX_FMT_RGB24, kFlags, nullptr, nullptr, nullptr));
    if (converter == nullptr) throw Error(fmt::format("{}: colours of its kind are not read", name));
    const int* matrix = sws_getCoefficients(color_space(*frame));
    const int is_full = frame->color_range == AVCOL_RANGE_JPEG ? 1 : 0;
    sws_setColorspaceDetails(converter.get(), matrix, is_full, sws_getCoefficients(SWS_CS_DEFAULT), 1, 0, 1 << 16, 1 << 16);
    // Rows of their own length: the converter may write whole vectors.
    const int row_bytes = (width * kPixelBytes + kAlignment - 1) / kAlignment * kAlignment + kAlignment;
    std::vector<std::uint8_t> rows(static_cast<std::size_t>(row_bytes) * static_cast<std::size_t>(height));
    std::uint8_t* const target[] = {rows.data()};
    const int strides[] = {row_bytes};
    sws_scale(converter.get(), frame->data, frame->linesize, 0, height, target, strides);
    Image<Rgb> image(width, height);
    for (int v = 0; v < height; ++v) {
      const std::uint8_t* row = rows.data() + static_cast<std::ptrdiff_t>(v) * row_bytes;
      for (int u = 0; u < width; ++u) image(u, v) = {row[3 * u], row[3 * u + 1], row[3 * u + 2]};
    }
    return image;
  }
};

bool reads_videos() { return true; }

Video::Video(const std::filesystem::path& path) : decoder_(std::make_unique<Decoder>(path)) {}
Video::~Video() = default;

std::size_t Video::size() const { return decoder_->images.size(); }
bool Video::is_cut_off() const { return decoder_->is_cut_off; }
int Video::width() const { return decoder_->codec->width; }
int Video::height() const { return decoder_->codec->height; }

Image<Rgb> Video::read(std::size_t position) const {
  Decoder& d = *decoder_;
  PANOPTIC_ASSERT(position < d.images.size());
  const std::lock_guard lock(d.mutex);
  d.go_to(position);
  while (!d.last || *d.last < position) {
    if (d.next()) continue;
    d.last.reset();  // the decoder is empty: the next search starts anew
    d.refuse(position);
  }
  if (*d.last > position || d.damaged) d.refuse(position);
  return d.converted();
}

}  // namespace panoptic

#else  // without FFmpeg's libraries

namespace panoptic {

struct Video::Decoder {};

bool reads_videos() { return false; }

Video::Video(const std::filesystem::path& path) {
  const std::string folder = (path.parent_path() / path.stem()).string();
  throw Error(fmt::format(
      "{0}: this build reads no videos: install libavformat-dev, libavcodec-dev and libswscale-dev and build anew, or "
      "extract the images: mkdir {1} && ffmpeg -ignore_editlist 1 -noautorotate -i {0} -fps_mode passthrough -start_number 0 "
      "-q:v 2 "
      "{1}/%06d.jpg",
      path.string(), folder));
}
Video::~Video() = default;

std::size_t Video::size() const { return 0; }
bool Video::is_cut_off() const { return false; }
int Video::width() const { return 0; }
int Video::height() const { return 0; }
Image<Rgb> Video::read(std::size_t) const { return {}; }

}  // namespace panoptic

#endif
