// SPDX-License-Identifier: Apache-2.0
#include "trust/server_probe.h"

#include <fcntl.h>
#include <netdb.h>
#include <openssl/ssl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <memory>

#include "core/clock.h"
#include "trust/host_port.h"

namespace livegs {
namespace {

// Time limit of the connection and the handshake together: some round trips of 250 ms.
constexpr int64_t kProbeTimeout_ns = 2'000'000'000;

class Socket {
 public:
  explicit Socket(int descriptor) : descriptor_(descriptor) {}
  ~Socket() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  int descriptor() const { return descriptor_; }
  // Waits until the socket can be read or written. False at the time limit.
  bool wait(short events, int64_t until_ns) const {
    pollfd waiting{descriptor_, events, 0};
    const int64_t left_ms = (until_ns - now_ns()) / 1'000'000;
    return left_ms > 0 && ::poll(&waiting, 1, static_cast<int>(left_ms)) == 1;
  }

 private:
  const int descriptor_;
};

bool connect_to(const Socket& socket, const addrinfo& where, int64_t until_ns) {
  if (socket.descriptor() < 0) return false;
  if (::connect(socket.descriptor(), where.ai_addr, where.ai_addrlen) == 0) return true;
  if (errno != EINPROGRESS || !socket.wait(POLLOUT, until_ns)) return false;
  int error = 0;
  socklen_t size = sizeof error;
  return ::getsockopt(socket.descriptor(), SOL_SOCKET, SO_ERROR, &error, &size) == 0 && error == 0;
}

bool shake_hands(const Socket& socket, int64_t until_ns) {
  const std::unique_ptr<SSL_CTX, void (*)(SSL_CTX*)> context(SSL_CTX_new(TLS_client_method()), SSL_CTX_free);
  if (!context) return false;
  SSL_CTX_set_verify(context.get(), SSL_VERIFY_NONE, nullptr);
  const std::unique_ptr<SSL, void (*)(SSL*)> ssl(SSL_new(context.get()), SSL_free);
  static constexpr unsigned char kHttp2[] = {2, 'h', '2'};  // gRPC refuses handshakes without it
  if (!ssl || SSL_set_alpn_protos(ssl.get(), kHttp2, sizeof kHttp2) != 0 ||
      SSL_set_fd(ssl.get(), socket.descriptor()) != 1)
    return false;
  for (;;) {
    const int done = SSL_connect(ssl.get());
    if (done == 1) return true;
    const int wanted = SSL_get_error(ssl.get(), done);
    if (wanted != SSL_ERROR_WANT_READ && wanted != SSL_ERROR_WANT_WRITE) return false;
    if (!socket.wait(wanted == SSL_ERROR_WANT_READ ? POLLIN : POLLOUT, until_ns)) return false;
  }
}

}  // namespace

bool speaks_tls(const std::string& address) {
  const auto parsed = parse_host_port(address);
  if (!parsed) return false;
  std::string host = parsed->host;
  if (host.size() > 2 && host.front() == '[') host = host.substr(1, host.size() - 2);
  addrinfo hints{}, *found = nullptr;
  hints.ai_socktype = SOCK_STREAM;
  if (::getaddrinfo(host.c_str(), std::to_string(parsed->port).c_str(), &hints, &found) != 0) return false;
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> addresses(found, ::freeaddrinfo);
  const int64_t until_ns = now_ns() + kProbeTimeout_ns;
  for (const addrinfo* one = found; one != nullptr; one = one->ai_next) {
    const Socket socket(::socket(one->ai_family, one->ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    if (connect_to(socket, *one, until_ns)) return shake_hands(socket, until_ns);
  }
  return false;
}

}  // namespace livegs
