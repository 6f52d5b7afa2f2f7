// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <grpcpp/server_builder.h>

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "core/result.h"

namespace livegs {

// A client has three connections: its stream, its assets, its control calls.
inline constexpr size_t kMaxConnections = 1024;
// From one address that is not this machine's, so that nobody alone keeps the others out.
inline constexpr size_t kMaxConnectionsPerAddress = 256;

// Listens, and hands connections to gRPC as long as there are not too many; gRPC itself takes any number. One
// that is too many is closed at once. On a thread of its own.
class ConnectionLimiter {
 public:
  // Listens on every address that HOST stands for, on one port; 0 lets the system choose it. Unavailable when
  // the port is in use or the host is none of this machine's.
  static Result<std::unique_ptr<ConnectionLimiter>> listen(const std::string& host, int port);
  ~ConnectionLimiter();
  ConnectionLimiter(const ConnectionLimiter&) = delete;
  ConnectionLimiter& operator=(const ConnectionLimiter&) = delete;

  int port() const { return port_; }
  // From now on connections are taken; those that came before wait in the system's queue.
  void open(std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> to);
  // From now on nobody gets in; those who are in stay. More than once is fine.
  void close();

 private:
  // A connection that gRPC has. It closes it when it likes, and tells nobody: it is still there as long as
  // its descriptor is the same socket.
  struct Admitted {
    int descriptor = -1;
    unsigned long inode = 0;
    std::string address;
    bool here() const;
  };
  ConnectionLimiter() = default;
  void run();
  void take(int listener);
  bool has_room(const std::string& address, bool loopback);

  std::vector<int> listeners_;
  int port_ = 0;
  int stop_ = -1;  // readable when the thread is to end
  std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> to_;
  std::vector<Admitted> admitted_;  // the thread's only
  std::thread thread_;
};

}  // namespace livegs
