// SPDX-License-Identifier: Apache-2.0
#include "session/access/connection_limiter.h"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <string>

#include "patience.h"

namespace livegs {
namespace {

// Keeps the connections it receives open, as gRPC does, until closed.
class Kept final : public grpc::experimental::ExternalConnectionAcceptor {
 public:
  struct Log {
    std::mutex mutex;
    std::condition_variable changed;
    std::vector<int> descriptors;

    size_t wait(size_t count) {
      std::unique_lock lock(mutex);
      changed.wait_for(lock, kPatience, [&] { return descriptors.size() >= count; });
      return descriptors.size();
    }
    void close_all() {
      std::lock_guard lock(mutex);
      for (const int descriptor : descriptors) ::close(descriptor);
      descriptors.clear();
    }
  };
  explicit Kept(Log& log) : log_(log) {}
  void HandleNewConnection(NewConnectionParameters* connection) override {
    std::lock_guard lock(log_.mutex);
    log_.descriptors.push_back(connection->fd);
    log_.changed.notify_all();
  }

 private:
  Log& log_;
};

int connect_to(int port) {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<uint16_t>(port));
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(::connect(socket, reinterpret_cast<sockaddr*>(&to), sizeof to), 0) << std::strerror(errno);
  return socket;
}

// A client of gRPC: the door passes it on after its first bytes.
int grpc_client(int port) {
  const int socket = connect_to(port);
  EXPECT_EQ(::send(socket, "PRI * HTTP/2.0\r\n", 16, 0), 16);
  return socket;
}

// Blocks until the other end closes the connection.
bool is_closed(int socket) {
  char byte = 0;
  return ::recv(socket, &byte, 1, 0) <= 0;
}

TEST(ConnectionLimiter, ClosesExcessConnections) {
  Kept::Log log;
  auto door = ConnectionLimiter::listen("127.0.0.1", 0);
  ASSERT_TRUE(door) << door.error().message;
  (*door)->open(std::make_unique<Kept>(log), [](int socket, bool) { ::close(socket); });
  std::vector<int> clients;
  for (size_t i = 0; i < kMaxConnections; ++i) clients.push_back(grpc_client((*door)->port()));
  EXPECT_EQ(log.wait(kMaxConnections), kMaxConnections);
  for (int i = 0; i < 3; ++i) {
    const int late = grpc_client((*door)->port());
    EXPECT_TRUE(is_closed(late));
    ::close(late);
  }
  EXPECT_EQ(log.wait(kMaxConnections), kMaxConnections);
  log.close_all();
  clients.push_back(grpc_client((*door)->port()));
  EXPECT_EQ(log.wait(1), 1u);
  log.close_all();
  for (const int client : clients) ::close(client);
}

TEST(ConnectionLimiter, SilentConnectionsGiveWayToNewOnes) {
  Kept::Log log;
  auto door = ConnectionLimiter::listen("127.0.0.1", 0);
  ASSERT_TRUE(door) << door.error().message;
  (*door)->open(std::make_unique<Kept>(log), [](int socket, bool) { ::close(socket); });
  std::vector<int> silent;
  for (size_t i = 0; i < kMaxConnections; ++i) silent.push_back(connect_to((*door)->port()));
  std::vector<int> clients;
  for (size_t i = 1; i <= 3; ++i) {
    clients.push_back(grpc_client((*door)->port()));
    EXPECT_EQ(log.wait(i), i);
    EXPECT_TRUE(is_closed(silent[i - 1])) << "the longest silent one";
  }
  char byte = 0;
  EXPECT_EQ(::recv(silent.back(), &byte, 1, MSG_DONTWAIT), -1) << "the latest one is still open";
  for (const int socket : silent) ::close(socket);
  for (const int socket : clients) ::close(socket);
  log.close_all();
}

TEST(ConnectionLimiter, NamesTheProblemOfAnAddress) {
  const auto door = ConnectionLimiter::listen("127.0.0.1", 0);
  ASSERT_TRUE(door);
  const auto second = ConnectionLimiter::listen("127.0.0.1", (*door)->port());
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().message.find("in use"), std::string::npos) << second.error().message;
  const auto far = ConnectionLimiter::listen("192.0.2.1", 0);  // reserved for documentation
  ASSERT_FALSE(far);
  EXPECT_NE(far.error().message.find("another address"), std::string::npos) << far.error().message;
  EXPECT_FALSE(ConnectionLimiter::listen("no.such.host.invalid", 0));
  for (const char* host : {"localhost", "0.0.0.0"}) EXPECT_TRUE(ConnectionLimiter::listen(host, 0)) << host;
}

TEST(ConnectionLimiter, TellsBrowsersFromGrpcByTheirFirstBytes) {
  Kept::Log log;
  auto door = ConnectionLimiter::listen("127.0.0.1", 0);
  ASSERT_TRUE(door) << door.error().message;
  std::mutex mutex;
  std::condition_variable changed;
  int browsers = 0;
  (*door)->open(std::make_unique<Kept>(log), [&](int socket, bool tls) {
    EXPECT_FALSE(tls);
    std::lock_guard lock(mutex);
    ++browsers;
    ::close(socket);
    changed.notify_all();
  });
  // Byte by byte, so that the door must wait for more.
  const int browser = connect_to((*door)->port());
  for (const char byte : std::string("GET / HTTP/1.1\r\n")) {
    if (::send(browser, &byte, 1, MSG_NOSIGNAL) != 1) break;
    ::usleep(2000);
  }
  {
    std::unique_lock lock(mutex);
    EXPECT_TRUE(changed.wait_for(lock, kPatience, [&] { return browsers == 1; }));
  }
  const int client = grpc_client((*door)->port());
  EXPECT_EQ(log.wait(1), 1u);
  // A client that ends within its first bytes is closed at once, a silent one after a while.
  const int silent = connect_to((*door)->port());
  const int cut = connect_to((*door)->port());
  EXPECT_EQ(::send(cut, "GE", 2, 0), 2);
  ::shutdown(cut, SHUT_WR);
  EXPECT_TRUE(is_closed(cut));
  char byte = 0;
  EXPECT_EQ(::recv(silent, &byte, 1, MSG_DONTWAIT), -1) << "the silent one is still open";
  EXPECT_TRUE(is_closed(silent));
  for (const int socket : {browser, client, silent, cut}) ::close(socket);
  log.close_all();
}

}  // namespace
}  // namespace livegs
