// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "core/clock.h"
#include "server/session/rpc/raw_client.h"

namespace livegs {

// Opens `connections` connections to the server in succession. Half of them send invalid data. A tenth join a
// session and leave; some of these never open a stream. Returns the highest rate over 20 successive
// connections, in connections per second.
inline double connection_storm(int port, int connections) {
  constexpr int kCounted = 20;
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  double rate = 0;
  int64_t counted_from_ns = now_ns();
  for (int i = 0; i < connections; ++i) {
    if (i > 0 && i % kCounted == 0) {
      rate = std::max(rate, kCounted / seconds_from_ns(now_ns() - counted_from_ns));
      counted_from_ns = now_ns();
    }
    const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
    EXPECT_EQ(::connect(socket, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    if (i % 2 == 0) (void)!::send(socket, "GET / HTTP/1.1\r\n\r\n", 18, MSG_NOSIGNAL);
    ::close(socket);
    if (i % 10 != 0) continue;
    RawClient passer_by(port);
    // A session that has left frees its slot once the server has detected it.
    int tries = 0;
    for (; !passer_by.join().ok() && tries < 2000; ++tries)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    EXPECT_LT(tries, 2000);
    if (i % 50 == 0) continue;  // joins without opening a stream
    passer_by.open();
    v1::ServerMessage message;
    EXPECT_TRUE(passer_by.read_any(
        message));  // the stream is open; a session that only joined keeps its slot for two minutes
    passer_by.cancel();
    EXPECT_FALSE(passer_by.finish_reading().ok());
  }
  return rate;
}

}  // namespace livegs
