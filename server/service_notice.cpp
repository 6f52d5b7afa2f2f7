// SPDX-License-Identifier: GPL-3.0-or-later
#include "service_notice.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <charconv>
#include <cstddef>
#include <cstdlib>
#include <cstring>

namespace livegs {

ServiceNotice::ServiceNotice() {
  const char* name = std::getenv("NOTIFY_SOCKET");
  if (name == nullptr || (name[0] != '/' && name[0] != '@') ||
      std::strlen(name) >= sizeof(sockaddr_un::sun_path))
    return;
  address_ = name;
  if (address_[0] == '@') address_[0] = '\0';
  ::unsetenv("NOTIFY_SOCKET");
  socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (const char* text = std::getenv("WATCHDOG_USEC"); text != nullptr) {
    int64_t watchdog_us = 0;
    std::from_chars(text, text + std::strlen(text), watchdog_us);
    liveness_ = TickLiveness(watchdog_us * 1000 / 2);
  }
}

ServiceNotice::~ServiceNotice() {
  if (socket_ >= 0) ::close(socket_);
}

void ServiceNotice::say(const std::string& state) const {
  if (socket_ < 0) return;
  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  std::memcpy(to.sun_path, address_.data(), address_.size());
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address_.size());
  (void)::sendto(socket_, state.data(), state.size(), MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&to),
                 size);
}

void ServiceNotice::feed(uint64_t ticks, int64_t now_ns) {
  if (liveness_.due(ticks, now_ns)) say("WATCHDOG=1");
}

}  // namespace livegs
