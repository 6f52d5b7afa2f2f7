// SPDX-License-Identifier: Apache-2.0
#include "gaussian/asset/decompress.h"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <limits>

#include "core/assert.h"

namespace livegs {
namespace {

constexpr int kGzipWindowBits = 15 + 16;  // zlib: adding 16 requires a gzip header and trailer
constexpr size_t kFirstPiece = size_t{1} << 20;
constexpr int kFileZstdLevel = 12;

}  // namespace

struct GunzipStream::State {
  z_stream stream{};
  Bytes input;         // not yet passed to zlib
  bool ended = false;  // the trailer was read and verified
};

GunzipStream::GunzipStream(Bytes compressed, std::string_view name)
    : state_(std::make_unique<State>()), name_(name) {
  state_->input = compressed;
  LIVEGS_ASSERT(inflateInit2(&state_->stream, kGzipWindowBits) == Z_OK);
}

GunzipStream::~GunzipStream() { inflateEnd(&state_->stream); }

// Fills `out` until the stream ends. The result is shorter than `size` only at the end.
Result<size_t> GunzipStream::inflate_into(std::byte* out, size_t size) {
  z_stream& stream = state_->stream;
  size_t done = 0;
  while (done < size && !state_->ended) {
    if (stream.avail_in == 0 && !state_->input.empty()) {
      const size_t piece = std::min<size_t>(state_->input.size(), std::numeric_limits<uInt>::max());
      stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(state_->input.data()));
      stream.avail_in = static_cast<uInt>(piece);
      state_->input = state_->input.subspan(piece);
    }
    const size_t wanted = std::min<size_t>(size - done, std::numeric_limits<uInt>::max());
    stream.next_out = reinterpret_cast<Bytef*>(out + done);
    stream.avail_out = static_cast<uInt>(wanted);
    const int status = inflate(&stream, Z_NO_FLUSH);
    done += wanted - stream.avail_out;
    if (status == Z_STREAM_END) {
      state_->ended = true;
    } else if (status == Z_BUF_ERROR) {
      return invalid_data(name_ + ": the gzip stream is truncated");
    } else if (status != Z_OK) {
      return invalid_data(name_ + ": the gzip stream is damaged (" +
                          (stream.msg ? stream.msg : "no reason reported") + ")");
    }
  }
  return done;
}

Result<std::vector<std::byte>> GunzipStream::take(size_t size) {
  std::vector<std::byte> bytes;
  size_t done = 0;
  while (done < size) {
    bytes.resize(std::min(size, std::max(2 * done, kFirstPiece)));
    const Result<size_t> got = inflate_into(bytes.data() + done, bytes.size() - done);
    if (!got) return got.error();
    done += *got;
    if (done < bytes.size()) {
      return invalid_data(name_ + ": the gzip stream ends " + std::to_string(size - done) +
                          " bytes before the size in its header");
    }
  }
  return bytes;
}

Result<size_t> GunzipStream::drain(std::vector<std::byte>* kept, size_t kept_bytes) {
  std::array<std::byte, 65536> piece;
  size_t left = 0;
  while (!state_->ended) {
    const Result<size_t> got = inflate_into(piece.data(), piece.size());
    if (!got) return got.error();
    if (kept && left < kept_bytes)
      kept->insert(kept->end(), piece.begin(),
                   piece.begin() + static_cast<ptrdiff_t>(std::min(*got, kept_bytes - left)));
    left += *got;
  }
  const size_t behind = state_->stream.avail_in + state_->input.size();
  if (behind) return invalid_data(name_ + ": " + std::to_string(behind) + " bytes follow the gzip stream");
  return left;
}

std::vector<std::byte> gzip(Bytes bytes) {
  z_stream stream{};
  LIVEGS_ASSERT(bytes.size() <= std::numeric_limits<uInt>::max());
  LIVEGS_ASSERT(deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kGzipWindowBits, 8,
                             Z_DEFAULT_STRATEGY) == Z_OK);
  std::vector<std::byte> out(deflateBound(&stream, bytes.size()));
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  LIVEGS_ASSERT(deflate(&stream, Z_FINISH) == Z_STREAM_END);
  out.resize(out.size() - stream.avail_out);
  deflateEnd(&stream);
  return out;
}

Result<std::vector<std::byte>> zstd_decompress(Bytes frame, size_t size, std::string_view name) {
  std::vector<std::byte> bytes(size);
  const size_t got = ZSTD_decompress(bytes.data(), bytes.size(), frame.data(), frame.size());
  if (ZSTD_isError(got))
    return invalid_data(std::string(name) + ": a zstd stream is damaged (" + ZSTD_getErrorName(got) + ")");
  if (got != size)
    return invalid_data(std::string(name) + ": a zstd stream ends " + std::to_string(size - got) +
                        " bytes before the size in its header");
  return bytes;
}

std::vector<std::byte> zstd_compress(Bytes bytes) {
  std::vector<std::byte> out(ZSTD_compressBound(bytes.size()));
  const size_t size = ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), kFileZstdLevel);
  LIVEGS_ASSERT(!ZSTD_isError(size));
  out.resize(size);
  return out;
}

}  // namespace livegs
