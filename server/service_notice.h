// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>

#include "session/support/tick_liveness.h"

namespace livegs {

// Status notifications to systemd for a service of Type=notify: datagrams to the socket NOTIFY_SOCKET
// (sd_notify(3)). Does nothing if that variable is not set.
class ServiceNotice {
 public:
  ServiceNotice();  // reads NOTIFY_SOCKET and WATCHDOG_USEC; unsets the former
  ~ServiceNotice();
  ServiceNotice(const ServiceNotice&) = delete;
  ServiceNotice& operator=(const ServiceNotice&) = delete;

  void say(const std::string& state) const;  // "READY=1", "STOPPING=1", "STATUS=…"
  // Notifies the watchdog twice per timeout, as long as `ticks` increases. systemd restarts a server whose
  // ticks stop.
  void feed(uint64_t ticks, int64_t now_ns);

 private:
  int socket_ = -1;
  std::string address_;  // sun_path, with a leading zero for an abstract socket
  TickLiveness liveness_{0};
};

}  // namespace livegs
