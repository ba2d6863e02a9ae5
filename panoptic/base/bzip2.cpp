// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The one source that knows libbz2.
#include <bzlib.h>

#include <algorithm>
#include <climits>
#include <new>

#include "panoptic/base/unpacking.h"

namespace panoptic {
namespace {

// An open stream, closed at its end.
class Stream {
 public:
  Stream() {
    if (BZ2_bzDecompressInit(&stream_, 0, 0) != BZ_OK) throw std::bad_alloc();
  }
  ~Stream() { BZ2_bzDecompressEnd(&stream_); }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  bz_stream* operator->() { return &stream_; }
  bz_stream* get() { return &stream_; }

 private:
  bz_stream stream_{};
};

unsigned chunk_of(std::size_t bytes) { return static_cast<unsigned>(std::min<std::size_t>(bytes, INT_MAX)); }

}  // namespace

UnpackedBytes unpacked_bzip2(PackedBytes packed, std::size_t size) {
  Stream stream;
  return unpacked_in_steps(packed.size(), size, [&](std::span<std::uint8_t> to, std::size_t& filled) {
    const unsigned given = chunk_of(packed.size());
    const unsigned room = chunk_of(to.size());
    // The library reads the bytes and does not change them; its interface has no const.
    stream->next_in = const_cast<char*>(reinterpret_cast<const char*>(packed.data()));  // NOLINT(*-const-cast)
    stream->avail_in = given;
    stream->next_out = reinterpret_cast<char*>(to.data());
    stream->avail_out = room;
    const int code = BZ2_bzDecompress(stream.get());
    packed = packed.subspan(given - stream->avail_in);
    filled = room - stream->avail_out;
    if (code == BZ_STREAM_END) return Unpacking::kDone;
    if (code != BZ_OK || (filled == 0 && given == stream->avail_in)) return Unpacking::kDamaged;
    return Unpacking::kGoesOn;
  });
}

}  // namespace panoptic
