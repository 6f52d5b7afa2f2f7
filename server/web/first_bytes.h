// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace livegs {

// Bytes after which first_protocol() no longer waits: the largest record of a TLS handshake, and its header.
inline constexpr size_t kMaxFirstBytes = 16'384 + 5;

enum class FirstProtocol : uint8_t {
  Undecided,  // more bytes are needed
  Grpc,       // HTTP/2, in the clear or by the ALPN of the ClientHello
  Web,        // HTTP/1.1 in the clear
  WebTls,     // HTTP/1.1 over TLS
};

// Returns the protocol of a connection by the first bytes from its client. One port serves gRPC and browsers.
// Clients of gRPC offer only h2 in the ALPN extension (RFC 7301) of their ClientHello (RFC 8446, section
// 4.1.2). Browsers offer also or only http/1.1. A ClientHello without ALPN is from a simple HTTP client. In
// the clear, HTTP/2 begins with "PRI * HTTP/2.0" (RFC 9113, section 3.4). All other bytes are classified as
// Grpc, which refuses them. Accepts any bytes; pure function.
FirstProtocol first_protocol(std::span<const std::byte> first);

}  // namespace livegs
