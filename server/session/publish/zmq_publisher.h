// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "core/result.h"
#include "wire/publication.h"

namespace livegs {

// Publishes frames to whoever listens on this machine, by ZeroMQ: each by itself (a key frame), in one part,
// without a topic, so that a subscriber with ZMQ_CONFLATE has the newest and never an old one, however slow
// it is. Nobody is asked who he is: that is why other machines are refused. One thread, but for address().
class ZmqPublisher {
 public:
  // tcp://127.0.0.1:PORT, tcp://localhost:PORT or tcp://[::1]:PORT; port 0 lets the system choose.
  // InvalidArgument for others, Unavailable when the port is in use.
  static Result<std::unique_ptr<ZmqPublisher>> bind(const std::string& address);
  ~ZmqPublisher();

  const std::string& address() const;  // as it was bound
  // Whether anybody listens: else a frame need not be made.
  bool has_subscribers();
  // Never waits; who does not keep up misses it.
  void publish(const Publication& publication);
  uint64_t published() const { return published_; }

 private:
  struct Socket;
  explicit ZmqPublisher(std::unique_ptr<Socket> socket);
  std::unique_ptr<Socket> socket_;
  std::atomic<uint64_t> published_{0};
};

}  // namespace livegs
