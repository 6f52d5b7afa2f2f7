// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/support/status.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace livegs {

// Limits of one request, bytes. A larger one ends its connection.
inline constexpr size_t kMaxWebHeaderBytes = 16u << 10, kMaxWebBodyBytes = 64u << 10;

// Transfer of one asset to a browser. Used by one thread.
class WebFetch {
 public:
  virtual ~WebFetch() = default;
  virtual std::span<const std::byte> bytes() const = 0;  // proto/asset_format.md
  // The bytes that may be sent now, or none and the time until the next call.
  struct Turn {
    size_t bytes = 0;
    int64_t wait_ns = 0;
  };
  virtual Turn take_turn(size_t max_bytes) = 0;
};

// Functions of the server that the web server calls, on the thread of the web server.
class WebBackend {
 public:
  virtual ~WebBackend() = default;
  virtual std::shared_ptr<grpc::Channel>
  channel() = 0;  // to the gRPC server of this process, without credentials
  // Whether the caller may call the RPC `path`. `authorization`: "Bearer TOKEN"; empty: no token.
  virtual grpc::Status authorise(const std::string& path, const std::string& authorization) = 0;
  // `base`: hash of the asset of which `hash` is fetched as an edit; empty: the whole asset. `session`: id of
  // the session whose bandwidth limit counts; empty: none. Null: no such asset or edit.
  virtual std::unique_ptr<WebFetch> fetch(const std::string& hash, const std::string& base,
                                          const std::string& session, const std::string& authorization) = 0;
  // The token for a one-time code. PermissionDenied for a wrong, used or expired code.
  virtual Result<std::string> pair(std::string_view code) = 0;
};

// HTTP/1.1 and WebSocket for browsers: the page, assets, RPCs as POST requests, and the Stream RPC as a
// WebSocket whose messages have the bytes of gRPC. See server/web/README.md. Sockets come from the
// ConnectionLimiter, which shares the port with gRPC. All work is done on an internal thread.
class WebServer {
 public:
  // With TLS if the PEM texts are not empty. `backend` must outlive close(). InvalidData for an unusable
  // certificate.
  static Result<std::unique_ptr<WebServer>> start(WebBackend& backend, const std::string& certificate_pem,
                                                  const std::string& key_pem);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  // Sites ("https://example.org") whose pages may show the scene in a frame (page/livegs-view.js). They get
  // no access to calls, assets or the stream. For pages that are requested later. Any thread.
  void allow_origins(std::vector<std::string> origins);

  // Another origin to which the page may connect: that of an asset store. For pages that are requested
  // later. Any thread.
  void connect_to(std::string origin);

  // Takes over a connected socket. `tls`: its first bytes are a TLS handshake. Any thread.
  void take(int socket, bool tls);
  // Waits up to a second for streams to send their last message, then closes all connections. May be called
  // more than once.
  void close();

 private:
  struct Parts;
  explicit WebServer(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace livegs
