// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

// Internal to web_server.cpp, the only source that compiles Boost.Beast.

namespace livegs::web {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using tcp = asio::ip::tcp;
using boost::system::error_code;
using std::chrono::seconds;

// Time limits of a request, from its first byte, and of an answer. A slower client is disconnected.
inline constexpr seconds kRequestTimeout{5}, kAnswerTimeout{30};
// Between two requests on one connection.
inline constexpr seconds kIdleTimeout{60};
// A part of an asset that is written at once.
inline constexpr size_t kPartBytes = 64u << 10;

// A TCP connection, with TLS or without. Its handlers have one type, so that Beast's algorithms are compiled
// once. At most one read and one write are in progress.
class ByteStream {
 public:
  using executor_type = asio::io_context::executor_type;
  using Done = std::function<void(error_code, size_t)>;

  ByteStream(asio::io_context& io, tcp::socket socket, asio::ssl::context* tls)
      : parts_(std::make_unique<Parts>(io, std::move(socket), tls)) {}

  executor_type get_executor() const { return parts_->io.get_executor(); }
  bool tls() const { return parts_->tls.has_value(); }
  void expires_after(std::chrono::nanoseconds time) { parts_->tcp.expires_after(time); }
  void expires_never() { parts_->tcp.expires_never(); }
  void close() { parts_->tcp.close(); }

  void handshake(std::function<void(error_code)> done) {
    if (!parts_->tls) return done({});
    parts_->tls->async_handshake(asio::ssl::stream_base::server, std::move(done));
  }
  void shut_down(std::function<void(error_code)> done) {
    if (parts_->tls) {
      parts_->tcp.expires_after(kRequestTimeout);
      return parts_->tls->async_shutdown(std::move(done));
    }
    error_code failed;
    parts_->tcp.socket().shutdown(tcp::socket::shutdown_send, failed);
    asio::post(parts_->io, [done = std::move(done), failed] { done(failed); });
  }

  // The concept AsyncStream of Asio.
  template <class Buffers, class Token>
  auto async_read_some(const Buffers& buffers, Token&& token) {
    return asio::async_initiate<Token, void(error_code, size_t)>(
        [this](auto handler, asio::mutable_buffer to) { read(to, erased(std::move(handler))); }, token,
        first_of(buffers));
  }
  template <class Buffers, class Token>
  auto async_write_some(const Buffers& buffers, Token&& token) {
    return asio::async_initiate<Token, void(error_code, size_t)>(
        [this](auto handler, asio::const_buffer from) { write(from, erased(std::move(handler))); }, token,
        joined(buffers));
  }

 private:
  struct Parts {
    Parts(asio::io_context& given, tcp::socket socket, asio::ssl::context* context)
        : io(given), tcp(std::move(socket)) {
      if (context) tls.emplace(tcp, *context);
    }
    asio::io_context& io;
    beast::tcp_stream tcp;
    std::optional<asio::ssl::stream<beast::tcp_stream&>> tls;
    std::vector<char> together;  // several buffers of one write
  };

  // std::function copies its callable, which handlers do not allow.
  template <class Handler>
  static Done erased(Handler handler) {
    return [shared = std::make_shared<Handler>(std::move(handler))](error_code failed, size_t size) {
      std::move (*shared)(failed, size);
    };
  }
  template <class Buffers>
  static asio::mutable_buffer first_of(const Buffers& buffers) {
    for (auto one = asio::buffer_sequence_begin(buffers); one != asio::buffer_sequence_end(buffers); ++one) {
      if (asio::mutable_buffer(*one).size() > 0) return *one;
    }
    return {};
  }
  // All buffers in one, so that the head and the body of a message are one segment.
  template <class Buffers>
  asio::const_buffer joined(const Buffers& buffers) {
    size_t count = 0, total = 0;
    asio::const_buffer only;
    for (auto one = asio::buffer_sequence_begin(buffers); one != asio::buffer_sequence_end(buffers); ++one) {
      const asio::const_buffer buffer(*one);
      if (buffer.size() == 0) continue;
      only = buffer;
      ++count;
      total += buffer.size();
    }
    if (count <= 1) return only;
    std::vector<char>& together = parts_->together;
    together.resize(std::min(total, kPartBytes));
    return {together.data(), asio::buffer_copy(asio::buffer(together), buffers)};
  }
  void read(asio::mutable_buffer to, Done done) {
    if (parts_->tls)
      parts_->tls->async_read_some(to, std::move(done));
    else
      parts_->tcp.async_read_some(to, std::move(done));
  }
  void write(asio::const_buffer from, Done done) {
    if (parts_->tls)
      parts_->tls->async_write_some(from, std::move(done));
    else
      parts_->tcp.async_write_some(from, std::move(done));
  }

  std::unique_ptr<Parts> parts_;
};

// Customisation points of Beast's WebSocket: the end of the connection.
inline void beast_close_socket(ByteStream& stream) { stream.close(); }
template <class Handler>
void async_teardown(beast::role_type, ByteStream& stream, Handler&& handler) {
  stream.shut_down([shared = std::make_shared<std::decay_t<Handler>>(std::forward<Handler>(handler))](
                       error_code failed) { std::move (*shared)(failed); });
}

}  // namespace livegs::web
