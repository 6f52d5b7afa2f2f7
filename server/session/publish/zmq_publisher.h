// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "core/result.h"
#include "wire/publication.h"

namespace livegs {

// Publishes frames to local subscribers by ZeroMQ. Each frame is a keyframe in one part without a topic, so a
// slow subscriber with ZMQ_CONFLATE always has the newest one. Subscribers are not authenticated, so remote
// addresses are refused. One thread, except for address().
class ZmqPublisher {
 public:
  // Accepts tcp://127.0.0.1:PORT, tcp://localhost:PORT or tcp://[::1]:PORT; port 0 lets the system choose.
  // InvalidArgument for others, Unavailable if the port is in use.
  static Result<std::unique_ptr<ZmqPublisher>> bind(const std::string& address);
  ~ZmqPublisher();

  const std::string& address() const;  // as bound
  // True if there are subscribers; otherwise no frame is needed.
  bool has_subscribers();
  // Does not block; a slow subscriber misses frames.
  void publish(const Publication& publication);
  uint64_t published() const { return published_; }

 private:
  struct Socket;
  explicit ZmqPublisher(std::unique_ptr<Socket> socket);
  std::unique_ptr<Socket> socket_;
  std::atomic<uint64_t> published_{0};
};

}  // namespace livegs
