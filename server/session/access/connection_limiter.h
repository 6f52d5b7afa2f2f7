// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <grpcpp/server_builder.h>

#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "core/result.h"

namespace livegs {

// Total connections. A client has three: stream, assets and control calls.
inline constexpr size_t kMaxConnections = 1024;
// Connections from one remote address, so that a single host cannot use up the total.
inline constexpr size_t kMaxConnectionsPerAddress = 256;

// Time for the first bytes of a connection, from which its protocol follows.
inline constexpr int64_t kFirstBytesTimeout_ns = 3'000'000'000;

// Accepts connections on its own thread and passes them on, up to the limits above: to gRPC, or to the web
// server if the first bytes are those of a browser (web/first_bytes.h). gRPC itself has no such limit. Silent
// connections are closed after kFirstBytesTimeout_ns. At a limit, a new connection takes the place of the
// longest silent one; without one it is closed at once.
class ConnectionLimiter {
 public:
  // Listens on every address of `host`, on one port; port 0 lets the system choose. Unavailable if the port
  // is in use or the host is not an address of this machine.
  static Result<std::unique_ptr<ConnectionLimiter>> listen(const std::string& host, int port);
  ~ConnectionLimiter();
  ConnectionLimiter(const ConnectionLimiter&) = delete;
  ConnectionLimiter& operator=(const ConnectionLimiter&) = delete;

  int port() const { return port_; }
  // Called on the accepting thread with a connected socket, which the callee owns. `tls`: it begins with a
  // TLS handshake.
  using ToWeb = std::function<void(int socket, bool tls)>;
  // Starts accepting. Earlier connections wait in the backlog of the system.
  void open(std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> to, ToWeb to_web);
  // Stops accepting; open connections stay open. May be called more than once.
  void close();

 private:
  // A connection that was passed on; its owner closes it without notice. It is still open as long as its
  // descriptor refers to the same socket.
  struct Admitted {
    int descriptor = -1;
    unsigned long inode = 0;
    std::string address;
    bool here() const;
  };
  ConnectionLimiter() = default;
  void run();
  void take(int listener);
  // A connection whose first bytes have not arrived.
  struct Silent {
    int descriptor = -1, listener = -1;
    int64_t since_ns = 0;
    std::string address;
  };
  // `ended`: the client sends no more. False if more bytes are needed.
  bool pass_on(const Silent& one, bool ended);
  bool make_room(const std::string& address, bool loopback);

  std::vector<int> listeners_;
  int port_ = 0;
  int stop_ = -1;  // readable when the thread must end
  std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> to_;
  ToWeb to_web_;
  std::vector<Admitted> admitted_;  // accessed by the thread only, like silent_
  std::vector<Silent> silent_;      // longest silent first
  std::thread thread_;
};

}  // namespace livegs
