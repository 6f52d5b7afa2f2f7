// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/access/connection_limiter.h"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "core/clock.h"
#include "web/first_bytes.h"

namespace livegs {
namespace {

constexpr int kBacklog = 512;
// The value that gRPC sets on its own sockets: unacknowledged bytes end the connection after this time.
constexpr unsigned kTcpUserTimeout_ms = 3000;
// Wait before the next accept when the process has run out of descriptors.
constexpr useconds_t kDescriptorRetry_us = 50'000;

void set(int socket, int level, int option, int value) {
  ::setsockopt(socket, level, option, &value, sizeof value);
}

int port_of(int socket) {
  sockaddr_storage at{};
  socklen_t size = sizeof at;
  ::getsockname(socket, reinterpret_cast<sockaddr*>(&at), &size);
  return ntohs(at.ss_family == AF_INET6 ? reinterpret_cast<sockaddr_in6&>(at).sin6_port
                                        : reinterpret_cast<sockaddr_in&>(at).sin_port);
}

int listen_on(const addrinfo& address, int port) {
  const int socket = ::socket(address.ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (socket < 0) return -1;
  set(socket, SOL_SOCKET, SO_REUSEADDR, 1);
  sockaddr_storage at{};
  std::memcpy(&at, address.ai_addr, address.ai_addrlen);
  if (address.ai_family == AF_INET6) {
    // [::] accepts IPv4 and IPv6.
    const bool any = IN6_IS_ADDR_UNSPECIFIED(&reinterpret_cast<sockaddr_in6&>(at).sin6_addr);
    set(socket, IPPROTO_IPV6, IPV6_V6ONLY, any ? 0 : 1);
    reinterpret_cast<sockaddr_in6&>(at).sin6_port = htons(static_cast<uint16_t>(port));
  } else {
    reinterpret_cast<sockaddr_in&>(at).sin_port = htons(static_cast<uint16_t>(port));
  }
  if (::bind(socket, reinterpret_cast<sockaddr*>(&at), address.ai_addrlen) == 0 &&
      ::listen(socket, kBacklog) == 0)
    return socket;
  ::close(socket);
  return -1;
}

// Raises the descriptor limit: the usual 1024 is below connections and files together.
void allow_descriptors() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = std::max(limit.rlim_cur, std::min<rlim_t>(limit.rlim_max, 4 * kMaxConnections));
  ::setrlimit(RLIMIT_NOFILE, &limit);
}

// The peer address as text; sets `loopback` if the peer is this machine.
std::string address_of(const sockaddr_storage& from, socklen_t size, bool& loopback) {
  char host[NI_MAXHOST] = "";
  ::getnameinfo(reinterpret_cast<const sockaddr*>(&from), size, host, sizeof host, nullptr, 0,
                NI_NUMERICHOST);
  const std::string text = std::string(host).starts_with("::ffff:") ? host + 7 : host;
  loopback = text == "::1" || text.starts_with("127.");
  return text;
}

unsigned long inode_of(int descriptor) {
  struct stat about {};
  return ::fstat(descriptor, &about) == 0 && S_ISSOCK(about.st_mode) ? about.st_ino : 0;
}

}  // namespace

bool ConnectionLimiter::Admitted::here() const { return inode_of(descriptor) == inode; }

Result<std::unique_ptr<ConnectionLimiter>> ConnectionLimiter::listen(const std::string& host, int port) {
  allow_descriptors();
  std::unique_ptr<ConnectionLimiter> door(new ConnectionLimiter);
  const bool bracketed = host.size() > 2 && host.front() == '[' && host.back() == ']';
  addrinfo wanted{}, *found = nullptr;
  wanted.ai_socktype = SOCK_STREAM;
  wanted.ai_flags = AI_PASSIVE;
  const std::string name = bracketed ? host.substr(1, host.size() - 2) : host;
  const std::string where = host + ":" + std::to_string(port);
  if (const int failed = ::getaddrinfo(name.c_str(), nullptr, &wanted, &found); failed != 0) {
    return Error{ErrorCode::Unavailable, "--listen " + where + ": " + ::gai_strerror(failed) +
                                             "; give a host name or an address of this machine"};
  }
  int why = 0;
  for (const addrinfo* address = found; address != nullptr; address = address->ai_next) {
    const int socket = listen_on(*address, door->port_ != 0 ? door->port_ : port);
    if (socket < 0) {
      why = errno;
      if (why == EADDRINUSE) break;
      continue;  // localhost may resolve to an address family that this machine does not have
    }
    door->listeners_.push_back(socket);
    door->port_ = port_of(socket);
  }
  ::freeaddrinfo(found);
  if (why == EADDRINUSE || door->listeners_.empty()) {
    return Error{ErrorCode::Unavailable,
                 "--listen " + where + ": " +
                     (why == EADDRINUSE ? "the port is in use; stop the other server, or give another port"
                                        : std::string(std::strerror(why)) + "; give another address")};
  }
  door->stop_ = ::eventfd(0, EFD_CLOEXEC);
  return door;
}

ConnectionLimiter::~ConnectionLimiter() {
  close();
  if (stop_ >= 0) ::close(stop_);
}

void ConnectionLimiter::close() {
  if (thread_.joinable()) {
    const uint64_t one = 1;
    while (::write(stop_, &one, sizeof one) < 0 && errno == EINTR) {
    }
    thread_.join();
  }
  for (const int listener : listeners_) ::close(listener);
  listeners_.clear();
}

void ConnectionLimiter::open(std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> to,
                             ToWeb to_web) {
  to_ = std::move(to);
  to_web_ = std::move(to_web);
  thread_ = std::thread([this] {
    pthread_setname_np(pthread_self(), "door");
    run();
  });
}

void ConnectionLimiter::run() {
  std::vector<pollfd> waiting;
  for (;;) {
    waiting = {{stop_, POLLIN, 0}};
    for (const int listener : listeners_) waiting.push_back({listener, POLLIN, 0});
    for (const Silent& one : silent_) waiting.push_back({one.descriptor, POLLIN | POLLRDHUP, 0});
    const int64_t now = now_ns();
    int64_t wait_ns = -1;
    for (const Silent& one : silent_) {
      const int64_t left_ns = std::max<int64_t>(0, one.since_ns + kFirstBytesTimeout_ns - now);
      wait_ns = wait_ns < 0 ? left_ns : std::min(wait_ns, left_ns);
    }
    const int wait_ms = wait_ns < 0 ? -1 : static_cast<int>(wait_ns / 1'000'000 + 1);
    if (::poll(waiting.data(), waiting.size(), wait_ms) < 0 && errno != EINTR) break;
    if (waiting[0].revents != 0) break;
    const size_t first_silent = 1 + listeners_.size();
    std::vector<Silent> still;
    for (size_t i = 0; i < silent_.size(); ++i) {
      const short events = waiting[first_silent + i].revents;
      const bool heard = events != 0, ended = (events & (POLLRDHUP | POLLHUP | POLLERR)) != 0;
      if (heard && pass_on(silent_[i], ended)) continue;
      if (!heard && now_ns() - silent_[i].since_ns > kFirstBytesTimeout_ns) {
        ::close(silent_[i].descriptor);
        continue;
      }
      still.push_back(silent_[i]);
    }
    silent_ = std::move(still);
    for (size_t i = 1; i < first_silent; ++i) {
      if (waiting[i].revents != 0) take(waiting[i].fd);
    }
  }
  for (const Silent& one : silent_) ::close(one.descriptor);
}

bool ConnectionLimiter::pass_on(const Silent& one, bool ended) {
  std::array<std::byte, kMaxFirstBytes> first;
  const ssize_t got = ::recv(one.descriptor, first.data(), first.size(), MSG_PEEK | MSG_DONTWAIT);
  if (got < 0 && (errno == EAGAIN || errno == EINTR)) return false;
  if (got <= 0 || now_ns() - one.since_ns > kFirstBytesTimeout_ns) {
    ::close(one.descriptor);
    return true;
  }
  const FirstProtocol protocol = first_protocol({first.data(), static_cast<size_t>(got)});
  if (protocol == FirstProtocol::Undecided && ended) {
    ::close(one.descriptor);
    return true;
  }
  if (protocol == FirstProtocol::Undecided) {
    set(one.descriptor, SOL_SOCKET, SO_RCVLOWAT,
        static_cast<int>(got) + 1);  // poll waits for more than what is here
    return false;
  }
  set(one.descriptor, SOL_SOCKET, SO_RCVLOWAT, 1);
  if (protocol != FirstProtocol::Grpc) {
    to_web_(one.descriptor, protocol == FirstProtocol::WebTls);
    return true;
  }
  grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters connection;
  connection.listener_fd = one.listener;
  connection.fd = one.descriptor;
  to_->HandleNewConnection(&connection);
  return true;
}

void ConnectionLimiter::take(int listener) {
  sockaddr_storage from{};
  socklen_t size = sizeof from;
  const int socket =
      ::accept4(listener, reinterpret_cast<sockaddr*>(&from), &size, SOCK_CLOEXEC | SOCK_NONBLOCK);
  if (socket < 0) {
    if (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM)
      ::usleep(kDescriptorRetry_us);
    return;
  }
  bool loopback = false;
  const std::string address = address_of(from, size, loopback);
  if (!make_room(address, loopback)) {
    ::close(socket);
    return;
  }
  set(socket, IPPROTO_TCP, TCP_NODELAY, 1);
  set(socket, IPPROTO_TCP, TCP_USER_TIMEOUT, kTcpUserTimeout_ms);
  admitted_.push_back({socket, inode_of(socket), address});
  silent_.push_back({socket, listener, now_ns(), address});
}

// Checks which connections are still open only when a limit seems to be reached.
bool ConnectionLimiter::make_room(const std::string& address, bool loopback) {
  for (const bool total : {false, true}) {
    if (!total && loopback) continue;
    const size_t limit = total ? kMaxConnections : kMaxConnectionsPerAddress;
    const auto counts = [&](const auto& one) { return total || one.address == address; };
    const auto full = [&] {
      return static_cast<size_t>(std::count_if(admitted_.begin(), admitted_.end(), counts)) >= limit;
    };
    if (!full()) continue;
    std::erase_if(admitted_, [](const Admitted& one) { return !one.here(); });
    if (!full()) continue;
    const auto longest = std::find_if(silent_.begin(), silent_.end(), counts);
    if (longest == silent_.end()) return false;
    ::close(longest->descriptor);
    std::erase_if(admitted_, [&](const Admitted& one) { return one.descriptor == longest->descriptor; });
    silent_.erase(longest);
  }
  return true;
}

}  // namespace livegs
