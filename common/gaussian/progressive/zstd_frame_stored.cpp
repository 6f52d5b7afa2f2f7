// SPDX-License-Identifier: Apache-2.0
// RFC 8878, section 3.1.1: zstd frames without compression, instead of zstd_frame.cpp. A frame is a magic
// number, a header, blocks of type raw or RLE, and an optional checksum, which is not verified: assets come
// over a transport that verifies its bytes.
#include <algorithm>
#include <cstring>

#include "gaussian/progressive/zstd_frame.h"

namespace livegs {
namespace {

constexpr uint32_t kMagic = 0xFD2FB528;
constexpr size_t kBlockHeadBytes = 3, kMaxBlockBytes = size_t{128} << 10;
enum BlockType : uint32_t { kRaw = 0, kRle = 1 };

// Visits the blocks of a frame: take(type, data, size of the content). Returns the size of the frame; nothing
// if it is cut short, has a compressed block, or `take` returns false.
template <class Take>
std::optional<size_t> each_block(Bytes bytes, const Take& take) {
  if (bytes.size() < 5 || load<uint32_t>(bytes, 0) != kMagic) return std::nullopt;
  const unsigned descriptor = byte_at(bytes, 4), size_code = descriptor >> 6;
  const bool one_segment = (descriptor & 0x20) != 0, has_checksum = (descriptor & 4) != 0;
  constexpr size_t kDictionaryBytes[4] = {0, 1, 2, 4}, kSizeBytes[4] = {0, 2, 4, 8};
  if ((descriptor & 8) != 0) return std::nullopt;  // reserved
  size_t at = 5 + (one_segment ? 0 : 1) + kDictionaryBytes[descriptor & 3] +
              (size_code == 0 && one_segment ? 1 : kSizeBytes[size_code]);
  for (bool last = false; !last;) {
    if (at + kBlockHeadBytes > bytes.size()) return std::nullopt;
    const uint32_t head = byte_at(bytes, at) | byte_at(bytes, at + 1) << 8 | byte_at(bytes, at + 2) << 16;
    last = (head & 1) != 0;
    const uint32_t type = head >> 1 & 3, size = head >> 3;
    at += kBlockHeadBytes;
    const size_t stored = type == kRle ? 1 : size;
    if (type > kRle || size > kMaxBlockBytes || stored > bytes.size() - at) return std::nullopt;
    if (!take(type, bytes.subspan(at, stored), size)) return std::nullopt;
    at += stored;
  }
  at += has_checksum ? 4 : 0;
  if (at > bytes.size()) return std::nullopt;
  return at;
}

}  // namespace

std::optional<size_t> zstd_frame_size(Bytes payload) {
  return each_block(payload, [](uint32_t, Bytes, size_t) { return true; });
}

std::optional<size_t> zstd_frame_content(Bytes frame, std::span<std::byte> out) {
  size_t done = 0;
  const auto whole = each_block(frame, [&](uint32_t type, Bytes data, size_t size) {
    if (size > out.size() - done) return false;
    if (type == kRle) std::fill_n(out.begin() + static_cast<std::ptrdiff_t>(done), size, data[0]);
    if (type == kRaw && size > 0) std::memcpy(out.data() + done, data.data(), size);
    done += size;
    return true;
  });
  if (!whole) return std::nullopt;
  return done;
}

}  // namespace livegs
