// SPDX-License-Identifier: Apache-2.0
#include "system/support/fault_proxy.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <stdexcept>

#include "core/clock.h"

namespace livegs {
namespace {

// Limit of queued bytes per direction, as in a router.
constexpr size_t kMaxQueuedBytes = 128u << 10;
constexpr size_t kReadBytes = 4096;  // about one transfer unit

sockaddr_in loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

void prepare(int socket) {
  const int one = 1, buffer = 64 << 10;
  ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
  ::setsockopt(socket, SOL_SOCKET, SO_RCVBUF, &buffer, sizeof buffer);
  ::setsockopt(socket, SOL_SOCKET, SO_SNDBUF, &buffer, sizeof buffer);
  ::fcntl(socket, F_SETFL, O_NONBLOCK);
}

}  // namespace

FaultProxy::FaultProxy(int server_port, uint64_t seed) : server_port_(server_port), random_(seed) {
  listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  sockaddr_in address = loopback(0);
  socklen_t length = sizeof address;
  if (::bind(listener_, reinterpret_cast<sockaddr*>(&address), length) != 0 ||
      ::listen(listener_, 128) != 0 ||
      ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &length) != 0) {
    throw std::runtime_error("fault proxy: no listening socket");
  }
  port_ = ntohs(address.sin_port);
  wake_ = ::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  thread_ = std::thread([this] { run(); });
}

FaultProxy::~FaultProxy() {
  stopping_ = true;
  wake();
  thread_.join();
  for (Connection& connection : open_) end(connection, false);
  ::close(listener_);
  ::close(wake_);
}

void FaultProxy::wake() {
  const uint64_t one = 1;
  (void)!::write(wake_, &one, sizeof one);
}

void FaultProxy::set_server(int server_port) {
  std::lock_guard lock(mutex_);
  server_port_ = server_port;
}

void FaultProxy::set_link(const Link& link) {
  std::lock_guard lock(mutex_);
  link_ = link;
}

void FaultProxy::stall(double seconds) {
  {
    std::lock_guard lock(mutex_);
    stalled_until_ns_ = now_ns() + static_cast<int64_t>(seconds * 1e9);
  }
  wake();
}

void FaultProxy::cut() {
  std::lock_guard lock(mutex_);
  cut_ = true;
  for (Connection& connection : open_) connection.dead = true;
}

void FaultProxy::heal() {
  std::lock_guard lock(mutex_);
  cut_ = false;
}

void FaultProxy::reset() {
  {
    std::lock_guard lock(mutex_);
    for (Connection& connection : open_) end(connection, true);
  }
  wake();
}

void FaultProxy::reset_after(uint64_t bytes, int connections) {
  std::lock_guard lock(mutex_);
  reset_after_bytes_ = bytes;
  resets_left_ = connections;
}

void FaultProxy::end(Connection& connection, bool with_reset) {
  if (connection.gone) return;
  const linger at_once{1, 0};
  for (int socket : {connection.client, connection.server}) {
    if (socket < 0) continue;
    if (with_reset) ::setsockopt(socket, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
    ::close(socket);
  }
  connection.gone = true;
}

void FaultProxy::take_connection() {
  const int client = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
  if (client < 0) return;
  ++connections_;
  prepare(client);
  Connection connection;
  connection.client = client;
  connection.dead = cut_;
  if (!connection.dead) {
    connection.server = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const sockaddr_in address = loopback(server_port_);
    // On loopback, connect() completes at once.
    if (::connect(connection.server, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
      end(connection, true);
      return;
    }
    prepare(connection.server);
  }
  open_.push_back(std::move(connection));
}

void FaultProxy::read(Connection& connection, bool from_client) {
  const int from = from_client ? connection.client : connection.server;
  Way& way = from_client ? connection.up : connection.down;
  Piece piece;
  piece.bytes.resize(kReadBytes);
  const ssize_t count = ::read(from, piece.bytes.data(), piece.bytes.size());
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (count < 0) return end(connection, true);  // one end was reset, so the other is reset too
  if (count == 0) {
    way.ended = true;
    return;
  }
  piece.bytes.resize(static_cast<size_t>(count));
  const int64_t now = now_ns();
  int64_t& free_ns = free_ns_[from_client ? 0 : 1];
  free_ns = std::max(free_ns, now);
  if (link_.mbit_s > 0) free_ns += static_cast<int64_t>(8e3 * static_cast<double>(count) / link_.mbit_s);
  const double extra_ms = std::uniform_real_distribution<double>(0, std::max(link_.jitter_ms, 1e-9))(random_);
  way.last_due_ns =
      std::max(way.last_due_ns, free_ns + static_cast<int64_t>(1e6 * (link_.delay_ms + extra_ms)));
  piece.due_ns = way.last_due_ns;
  way.waiting_bytes += piece.bytes.size();
  way.pieces.push_back(std::move(piece));
}

void FaultProxy::write(Connection& connection, bool to_client, int64_t now) {
  const int to = to_client ? connection.client : connection.server;
  Way& way = to_client ? connection.down : connection.up;
  while (!connection.gone && !way.pieces.empty() && way.pieces.front().due_ns <= now &&
         now >= stalled_until_ns_) {
    Piece& piece = way.pieces.front();
    const size_t left = piece.bytes.size() - piece.written;
    const ssize_t count = ::send(to, piece.bytes.data() + piece.written, left, MSG_NOSIGNAL);
    if (count < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (count < 0) return end(connection, true);
    piece.written += static_cast<size_t>(count);
    way.waiting_bytes -= static_cast<size_t>(count);
    if (to_client) {
      bytes_from_server_ += static_cast<uint64_t>(count);
      connection.brought += static_cast<uint64_t>(count);
      if (resets_left_ > 0 && connection.brought >= reset_after_bytes_) {
        --resets_left_;
        return end(connection, true);
      }
    }
    if (piece.written == piece.bytes.size()) way.pieces.pop_front();
  }
  if (!connection.gone && way.ended && !way.end_forwarded && way.pieces.empty()) {
    ::shutdown(to, SHUT_WR);
    way.end_forwarded = true;
  }
}

void FaultProxy::run() {
  std::vector<pollfd> polled;
  std::vector<std::pair<Connection*, bool>>
      whose;  // connection of each polled socket from the third on; true for the client's end
  while (!stopping_) {
    int64_t wake_ns = now_ns() + 1'000'000'000;
    {
      std::lock_guard lock(mutex_);
      const int64_t now = now_ns();
      for (Connection& connection : open_) {
        if (connection.gone) continue;
        if (connection.dead) continue;  // after a cut, not even the end of a connection is read
        write(connection, false, now);
        if (!connection.gone) write(connection, true, now);
        if (!connection.gone && connection.up.end_forwarded && connection.down.end_forwarded)
          end(connection, false);
      }
      open_.remove_if([](const Connection& connection) { return connection.gone; });
      polled.assign({{listener_, POLLIN, 0}, {wake_, POLLIN, 0}});
      whose.clear();
      for (Connection& connection : open_) {
        if (connection.dead) continue;
        for (const bool of_client : {true, false}) {
          const Way& from = of_client ? connection.up : connection.down;
          const Way& to = of_client ? connection.down : connection.up;
          short events = 0;
          if (!from.ended && from.waiting_bytes < kMaxQueuedBytes) events |= POLLIN;
          if (!to.pieces.empty()) {
            const int64_t due_ns = std::max(to.pieces.front().due_ns, stalled_until_ns_);
            if (due_ns <= now)
              events |= POLLOUT;
            else
              wake_ns = std::min(wake_ns, due_ns);
          }
          const int socket = of_client ? connection.client : connection.server;
          if (events == 0) continue;
          polled.push_back({socket, events, 0});
          whose.emplace_back(&connection, of_client);
        }
      }
    }
    const int64_t wait_ns = std::max<int64_t>(0, wake_ns - now_ns());
    const timespec timeout{static_cast<time_t>(wait_ns / 1'000'000'000),
                           static_cast<long>(wait_ns % 1'000'000'000)};
    ::ppoll(polled.data(), polled.size(), &timeout, nullptr);
    std::lock_guard lock(mutex_);
    if (polled[1].revents != 0) {
      uint64_t count = 0;
      (void)!::read(wake_, &count, sizeof count);
    }
    for (size_t i = 2; i < polled.size(); ++i) {
      auto [connection, of_client] = whose[i - 2];
      if (connection->gone || connection->dead || (polled[i].revents & (POLLIN | POLLHUP | POLLERR)) == 0)
        continue;
      const Way& way = of_client ? connection->up : connection->down;
      if (!way.ended) read(*connection, of_client);
    }
    if (polled[0].revents != 0) take_connection();
  }
}

}  // namespace livegs
