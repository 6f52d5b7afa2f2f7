// SPDX-License-Identifier: Apache-2.0
#include "test_http_server.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <thread>

namespace livegs {

struct TestHttpServer::State {
  Handler handler;
  Reply models;
  bool handles_all = false;
  OtherHandler others;
  int listener = -1, port = 0;
  std::atomic<int> receive_pause_ms = 0;
  mutable std::mutex mutex;  // guards the members below
  mutable std::condition_variable changed;
  bool stopping = false;
  std::vector<SeenRequest> posts;
  int at_once = 0, most_at_once = 0;
  std::vector<std::thread> connections;
  std::vector<int> sockets;
  std::mutex handling;
  std::thread acceptor;

  bool pause(int ms) const {  // returns false when the server stops
    std::unique_lock lock(mutex);
    return !changed.wait_for(lock, std::chrono::milliseconds(ms), [&] { return stopping; });
  }

  static bool send_all(int socket, std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t sent = ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (sent <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(sent));
    }
    return true;
  }

  bool receive(int socket, SeenRequest& request) const {
    std::string bytes;
    std::size_t head_end = std::string::npos, length = 0;
    char buffer[65536];
    while (head_end == std::string::npos || bytes.size() < head_end + 4 + length) {
      if (receive_pause_ms > 0 && !pause(receive_pause_ms)) return false;
      const ssize_t count = ::recv(socket, buffer, sizeof buffer, 0);
      if (count <= 0) return false;
      bytes.append(buffer, static_cast<std::size_t>(count));
      if (head_end == std::string::npos && (head_end = bytes.find("\r\n\r\n")) != std::string::npos) {
        const std::size_t at = bytes.find("Content-Length: ");
        if (at != std::string::npos && at < head_end)
          length = std::strtoul(bytes.c_str() + at + 16, nullptr, 10);
      }
    }
    request.head = bytes.substr(0, head_end);
    request.body = bytes.substr(head_end + 4);
    const std::size_t first = request.head.find(' '), second = request.head.find(' ', first + 1);
    request.method = request.head.substr(0, first);
    request.path = request.head.substr(first + 1, second - first - 1);
    return true;
  }

  void answer(int socket, const Reply& reply, bool head_only = false) {
    if (!reply.raw.empty()) {
      send_all(socket, reply.raw);
      return;
    }
    std::string head = "HTTP/1.1 " + std::to_string(reply.status) +
                       " Said\r\nContent-Type: " + reply.content_type +
                       "\r\nConnection: " + (reply.keep_alive ? "keep-alive" : "close") + "\r\n";
    if (!reply.content_type.starts_with("text/event-stream")) {
      head += "Content-Length: " + std::to_string(reply.body.size()) + "\r\n";
    }
    for (const std::string& line : reply.headers) head += line + "\r\n";
    if (reply.hang && reply.cut_after == 0) {
      pause(60000);
      return;
    }
    if (!send_all(socket, head + "\r\n") || head_only) return;
    const std::string_view body = std::string_view(reply.body).substr(0, reply.cut_after);
    const int no_delay = 1;  // one packet per write
    ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &no_delay, sizeof no_delay);
    const std::size_t piece = reply.piece_bytes ? reply.piece_bytes : std::max<std::size_t>(body.size(), 1);
    for (std::size_t at = 0; at < body.size(); at += piece) {
      if (at > 0 && reply.piece_delay_ms > 0 && !pause(reply.piece_delay_ms)) return;
      if (!send_all(socket, body.substr(at, piece))) return;
    }
    if (reply.hang) pause(60000);
  }

  void serve(int socket) {
    SeenRequest request;
    for (bool more = true; more && receive(socket, request); request = {}) {
      more = false;
      if (request.method == "POST" || handles_all) {
        int index = 0;
        {
          std::lock_guard lock(mutex);
          index = static_cast<int>(posts.size());
          posts.push_back(request);
          most_at_once = std::max(most_at_once, ++at_once);
          changed.notify_all();
        }
        Reply reply;
        {
          std::lock_guard one(handling);
          reply = handler(request, index);
        }
        const bool going = reply.delay_ms == 0 || pause(reply.delay_ms);
        {
          std::lock_guard lock(mutex);  // before the client can detect the end and reconnect
          --at_once;
        }
        if (going) answer(socket, reply);
        more = going && reply.keep_alive && !reply.hang;
      } else if (others) {
        const Reply reply = others(request);
        if (reply.delay_ms > 0 && !pause(reply.delay_ms)) break;
        answer(socket, reply, request.method == "HEAD");
        more = reply.keep_alive && !reply.hang && reply.cut_after == std::string::npos;
      } else {
        answer(socket, models);
        more = models.keep_alive;
      }
    }
    // The peer reads pending data before the end of the stream.
    ::shutdown(socket, SHUT_WR);
    std::lock_guard lock(mutex);
    std::erase(sockets, socket);
    ::close(socket);
  }

  void accept_all() {
    for (;;) {
      const int socket = ::accept(listener, nullptr, nullptr);
      std::lock_guard lock(mutex);
      if (socket < 0 || stopping) {
        if (socket >= 0) ::close(socket);
        return;
      }
      sockets.push_back(socket);
      connections.emplace_back([this, socket] { serve(socket); });
    }
  }
};

TestHttpServer::TestHttpServer(Handler handler, Reply models) : state_(std::make_unique<State>()) {
  state_->handler = std::move(handler);
  state_->models = std::move(models);
  start(0);
}

TestHttpServer::TestHttpServer(Handler handler, int port) : state_(std::make_unique<State>()) {
  state_->handler = std::move(handler);
  state_->handles_all = true;
  start(port);
}

TestHttpServer::TestHttpServer(OtherHandler others) : state_(std::make_unique<State>()) {
  state_->handler = [](const SeenRequest&, int) { return not_found_reply(); };
  state_->others = std::move(others);
  start(0);
}

void TestHttpServer::start(int port) {
  state_->listener = ::socket(AF_INET, SOCK_STREAM, 0);
  const int again = 1;
  ::setsockopt(state_->listener, SOL_SOCKET, SO_REUSEADDR, &again, sizeof again);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::bind(state_->listener, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) std::abort();
  if (::listen(state_->listener, 64) != 0) std::abort();
  socklen_t size = sizeof address;
  ::getsockname(state_->listener, reinterpret_cast<sockaddr*>(&address), &size);
  state_->port = ntohs(address.sin_port);
  state_->acceptor = std::thread([state = state_.get()] { state->accept_all(); });
}

TestHttpServer::~TestHttpServer() {
  {
    std::lock_guard lock(state_->mutex);
    state_->stopping = true;
    state_->changed.notify_all();
    for (const int socket : state_->sockets) ::shutdown(socket, SHUT_RDWR);
  }
  ::shutdown(state_->listener, SHUT_RDWR);
  state_->acceptor.join();
  ::close(state_->listener);
  for (std::thread& connection : state_->connections) connection.join();
}

std::string TestHttpServer::base_url() const { return origin() + "/v1"; }

std::string TestHttpServer::origin() const { return "http://127.0.0.1:" + std::to_string(state_->port); }

int TestHttpServer::port() const { return state_->port; }

std::vector<SeenRequest> TestHttpServer::posts() const {
  std::lock_guard lock(state_->mutex);
  return state_->posts;
}

void TestHttpServer::wait_for_posts(std::size_t count) const {
  std::unique_lock lock(state_->mutex);
  state_->changed.wait(lock, [&] { return state_->posts.size() >= count; });
}

bool TestHttpServer::wait_for_posts(std::size_t count, double seconds) const {
  std::unique_lock lock(state_->mutex);
  return state_->changed.wait_for(lock, std::chrono::duration<double>(seconds), [&] {
    return state_->stopping || state_->posts.size() >= count;
  }) && state_->posts.size() >= count;
}

int TestHttpServer::connections() const {
  std::lock_guard lock(state_->mutex);
  return static_cast<int>(state_->connections.size());
}

void TestHttpServer::receive_slowly(int pause_ms) {
  const int kept_bytes = 1 << 16;
  ::setsockopt(state_->listener, SOL_SOCKET, SO_RCVBUF, &kept_bytes, sizeof kept_bytes);
  state_->receive_pause_ms = pause_ms;
}

int TestHttpServer::most_at_once() const {
  std::lock_guard lock(state_->mutex);
  return state_->most_at_once;
}

}  // namespace livegs
