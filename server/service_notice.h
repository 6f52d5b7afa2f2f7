// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>

namespace livegs {

// What systemd is told of a service of Type=notify: a datagram to the socket NOTIFY_SOCKET names
// (sd_notify(3)). Does nothing where there is none.
class ServiceNotice {
 public:
  ServiceNotice();  // reads NOTIFY_SOCKET and WATCHDOG_USEC, and takes the first out of the environment
  ~ServiceNotice();
  ServiceNotice(const ServiceNotice&) = delete;
  ServiceNotice& operator=(const ServiceNotice&) = delete;

  void say(const std::string& state) const;  // "READY=1", "STOPPING=1", "STATUS=…"
  // Feeds the watchdog, twice in its time, as long as `ticks` rises: a server that stands still is started
  // anew.
  void feed(uint64_t ticks, int64_t now_ns);

 private:
  int socket_ = -1;
  std::string address_;  // sun_path, with a leading zero for an abstract one
  int64_t every_ns_ = 0, fed_ns_ = 0;
  uint64_t fed_ticks_ = 0;
};

}  // namespace livegs
