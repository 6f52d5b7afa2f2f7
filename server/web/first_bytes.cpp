// SPDX-License-Identifier: GPL-3.0-or-later
#include "web/first_bytes.h"

#include <algorithm>
#include <string_view>

namespace livegs {
namespace {

constexpr uint8_t kHandshakeRecord = 22, kClientHello = 1;
constexpr uint16_t kAlpnExtension = 16;

// Reads big-endian integers; after the end, everything is zero and ok() is false.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  size_t integer(size_t width) {
    size_t value = 0;
    for (const std::byte byte : take(width)) value = value << 8 | std::to_integer<size_t>(byte);
    return value;
  }
  std::span<const std::byte> take(size_t count) {
    if (count > bytes_.size()) {
      ok_ = false;
      bytes_ = {};
      return {};
    }
    const auto taken = bytes_.first(count);
    bytes_ = bytes_.subspan(count);
    return taken;
  }
  Reader block(size_t width) { return Reader(take(integer(width))); }
  bool ok() const { return ok_; }
  bool empty() const { return bytes_.empty(); }

 private:
  std::span<const std::byte> bytes_;
  bool ok_ = true;
};

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Whether the list of protocols of a ClientHello has HTTP/1.1, or is missing.
bool offers_http1(Reader hello) {
  hello.take(2 + 32);  // version, random
  hello.block(1);      // session id
  hello.block(2);      // cipher suites
  hello.block(1);      // compression methods
  Reader extensions = hello.block(2);
  while (!extensions.empty()) {
    const size_t type = extensions.integer(2);
    Reader content = extensions.block(2);
    if (type != kAlpnExtension) continue;
    Reader names = content.block(2);
    while (!names.empty()) {
      const size_t length = names.integer(1);
      if (text_of(names.take(length)) == "http/1.1") return true;
    }
    return false;
  }
  return hello.ok() && extensions.ok();
}

}  // namespace

FirstProtocol first_protocol(std::span<const std::byte> first) {
  if (first.empty()) return FirstProtocol::Undecided;
  if (std::to_integer<uint8_t>(first[0]) == kHandshakeRecord) {
    if (first.size() < 5) return FirstProtocol::Undecided;
    Reader record(first);
    record.take(3);
    const size_t length = record.integer(2);
    if (length + 5 > kMaxFirstBytes) return FirstProtocol::Grpc;
    if (first.size() < 5 + length) return FirstProtocol::Undecided;
    Reader handshake(first.subspan(5, length));
    if (handshake.integer(1) != kClientHello) return FirstProtocol::Grpc;
    return offers_http1(handshake.block(3)) ? FirstProtocol::WebTls : FirstProtocol::Grpc;
  }
  const std::string_view text = text_of(first);
  for (const std::string_view method : {"GET ", "HEAD ", "POST ", "OPTIONS "}) {
    if (text.starts_with(method)) return FirstProtocol::Web;
    if (method.starts_with(text)) return FirstProtocol::Undecided;
  }
  return FirstProtocol::Grpc;
}

}  // namespace livegs
