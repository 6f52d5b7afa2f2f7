// SPDX-License-Identifier: GPL-3.0-or-later
#include "web/content_coding.h"

#include <zlib.h>
#include <zstd.h>

#include <cctype>
#include <limits>
#include <string>

namespace livegs {
namespace {

constexpr int kZstdLevel = 3, kGzipLevel = 4;
constexpr int kGzipWindowBits = 15 + 16;  // zlib: 16 selects the header of gzip

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.front()))) text.remove_prefix(1);
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.remove_suffix(1);
  return text;
}

}  // namespace

std::string_view name_of(ContentCoding coding) {
  switch (coding) {
    case ContentCoding::Gzip:
      return "gzip";
    case ContentCoding::Zstd:
      return "zstd";
    case ContentCoding::Identity:
      break;
  }
  return "";
}

bool accepts_coding(std::string_view accept_encoding, std::string_view name) {
  while (!accept_encoding.empty()) {
    const size_t comma = accept_encoding.find(',');
    std::string_view one = accept_encoding.substr(0, comma);
    accept_encoding = comma == std::string_view::npos ? "" : accept_encoding.substr(comma + 1);
    const size_t semicolon = one.find(';');
    const std::string_view weight =
        semicolon == std::string_view::npos ? "" : trimmed(one.substr(semicolon + 1));
    if (trimmed(one.substr(0, semicolon)) != name) continue;
    // q=0, with up to three zeros after the point, refuses the coding.
    return !(weight.starts_with("q=0") && weight.find_first_of("123456789") == std::string_view::npos);
  }
  return false;
}

ContentCoding choose_coding(std::string_view accept_encoding) {
  for (const ContentCoding coding : {ContentCoding::Zstd, ContentCoding::Gzip}) {
    if (accepts_coding(accept_encoding, name_of(coding))) return coding;
  }
  return ContentCoding::Identity;
}

Result<std::vector<std::byte>> encode_content(std::span<const std::byte> bytes, ContentCoding coding) {
  std::vector<std::byte> out;
  switch (coding) {
    case ContentCoding::Identity:
      out.assign(bytes.begin(), bytes.end());
      return out;
    case ContentCoding::Zstd: {
      out.resize(ZSTD_compressBound(bytes.size()));
      const size_t size = ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), kZstdLevel);
      if (ZSTD_isError(size))
        return Error{ErrorCode::Internal, std::string("zstd: ") + ZSTD_getErrorName(size)};
      out.resize(size);
      return out;
    }
    case ContentCoding::Gzip: {
      const Error failed{ErrorCode::Internal, "gzip: could not compress"};
      if (bytes.size() > std::numeric_limits<uInt>::max()) return failed;
      z_stream stream{};
      if (deflateInit2(&stream, kGzipLevel, Z_DEFLATED, kGzipWindowBits, 8, Z_DEFAULT_STRATEGY) != Z_OK)
        return failed;
      out.resize(deflateBound(&stream, bytes.size()));
      stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(bytes.data()));
      stream.avail_in = static_cast<uInt>(bytes.size());
      stream.next_out = reinterpret_cast<Bytef*>(out.data());
      stream.avail_out = static_cast<uInt>(out.size());
      const int done = deflate(&stream, Z_FINISH);
      out.resize(stream.total_out);
      deflateEnd(&stream);
      if (done != Z_STREAM_END) return failed;
      return out;
    }
  }
  return out;
}

}  // namespace livegs
